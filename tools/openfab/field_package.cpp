// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/field_package.h"

#include <fmt/format.h>

namespace openfab::tools {

namespace {

constexpr const char* kModel = "3D/3dmodel.model";

constexpr const char* kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/><Default Extension="png" ContentType="image/png"/></Types>
)";

std::string relationships(const std::vector<std::pair<std::string, std::string>>& parts) {
    std::string out =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships "
        "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n";
    for (size_t i = 0; i < parts.size(); ++i)
        out += fmt::format(
            "<Relationship Target=\"/{}\" Id=\"r{}\" "
            "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/{}\"/>\n",
            parts[i].first, i, parts[i].second);
    return out + "</Relationships>\n";
}

}  // namespace

Result<void> FieldPackage::begin(const std::string& output) {
    Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(output);
    if (!file) return file.error();
    file_ = std::move(*file);
    Result<backends::OutputFile*> flushed = file_->flushed();
    if (!flushed) return flushed.error();
    Result<std::unique_ptr<backends::Package>> package = backends::Package::create(*flushed);
    if (!package) return package.error();
    package_ = std::move(*package);
    Result<void> done = package_->add("[Content_Types].xml", kContentTypes);
    return done ? package_->add("_rels/.rels", relationships({{kModel, "3dmodel"}})) : done;
}

Result<void> FieldPackage::add_sheet(const std::string& name, const std::vector<uint8_t>& png) {
    sheets_.emplace_back(name, "3dtexture");
    return package_->add(name, {reinterpret_cast<const char*>(png.data()), png.size()});
}

Result<void> FieldPackage::end(const std::string& model) {
    Result<void> done = package_->add(kModel, model);
    if (done && !sheets_.empty())
        done = package_->add("3D/_rels/3dmodel.model.rels", relationships(sheets_));
    if (done) done = package_->close();
    return done ? file_->keep() : done;
}

}  // namespace openfab::tools
