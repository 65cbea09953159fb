// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/nifti_header.h"

#include <algorithm>
#include <cstring>

#include "texture/messages.h"

namespace openfab::texture {

namespace {

constexpr size_t kOld = 348, kNew = 540;  // sizes of headers, which they begin with
constexpr std::string_view kNewMark("\0\r\n\032\n", 5);

/// The bytes of a header, in either order.
class Fields {
  public:
    Fields(std::string_view bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

    template <typename T>
    double number(size_t at) const {
        return static_cast<double>(value<T>(at));
    }
    template <typename T>
    int64_t whole(size_t at) const {
        return static_cast<int64_t>(value<T>(at));
    }
    template <typename T, size_t count>
    void numbers(size_t at, std::array<double, count>* out) const {
        for (size_t i = 0; i < count; ++i)
            (*out)[i] = number<T>(at + i * sizeof(T));
    }

  private:
    template <typename T>
    T value(size_t at) const {
        std::array<char, sizeof(T)> raw{};
        std::memcpy(raw.data(), bytes_.data() + at, raw.size());
        if (swapped_) std::reverse(raw.begin(), raw.end());
        T out;
        std::memcpy(&out, raw.data(), raw.size());
        return out;
    }
    std::string_view bytes_;
    bool swapped_;
};

bool is_old(std::string_view bytes) {
    return bytes.size() >= kOld && (bytes.substr(344, 4) == std::string_view("n+1\0", 4) ||
                                    bytes.substr(344, 4) == std::string_view("ni1\0", 4));
}
bool is_new(std::string_view bytes) {
    return bytes.size() >= kNew && (bytes.substr(4, 3) == "n+2" || bytes.substr(4, 3) == "ni2") &&
           bytes.substr(7, 5) == kNewMark;
}

}  // namespace

bool is_nifti(std::string_view bytes) {
    return is_old(bytes) || is_new(bytes);
}

Result<NiftiHeader> read_nifti_header(std::string_view bytes) {
    NiftiHeader h;
    const bool old = is_old(bytes);
    if (!old && !is_new(bytes)) return user_error(messages::kNotNifti);
    const auto size = static_cast<int64_t>(old ? kOld : kNew);
    h.swapped = Fields(bytes, false).whole<int32_t>(0) != size;
    const Fields f(bytes, h.swapped);
    if (f.whole<int32_t>(0) != size) return user_error(messages::kHeaderDamaged);
    h.detached = bytes[old ? 345 : 5] == 'i';
    if (old) {
        for (size_t i = 0; i < 8; ++i)
            h.dim[i] = f.whole<int16_t>(40 + 2 * i);
        h.datatype = f.whole<int16_t>(70);
        f.numbers<float>(76, &h.pixdim);
        h.offset = f.number<float>(108);
        h.slope = f.number<float>(112);
        h.intercept = f.number<float>(116);
        h.units = f.whole<uint8_t>(123);
        h.qform = f.whole<int16_t>(252);
        h.sform = f.whole<int16_t>(254);
        f.numbers<float>(256, &h.quaternion);
        f.numbers<float>(268, &h.shift);
        for (size_t row = 0; row < 3; ++row)
            f.numbers<float>(280 + 16 * row, &h.affine[row]);
        return h;
    }
    h.is_double = true;
    h.datatype = f.whole<int16_t>(12);
    for (size_t i = 0; i < 8; ++i)
        h.dim[i] = f.whole<int64_t>(16 + 8 * i);
    f.numbers<double>(104, &h.pixdim);
    h.offset = f.number<int64_t>(168);
    h.slope = f.number<double>(176);
    h.intercept = f.number<double>(184);
    h.qform = f.whole<int32_t>(344);
    h.sform = f.whole<int32_t>(348);
    f.numbers<double>(352, &h.quaternion);
    f.numbers<double>(376, &h.shift);
    for (size_t row = 0; row < 3; ++row)
        f.numbers<double>(400 + 32 * row, &h.affine[row]);
    h.units = f.whole<int32_t>(500);
    return h;
}

std::string nifti_data_file(const std::string& header_name) {
    const size_t dot = header_name.rfind('.');
    const bool upper = header_name.ends_with(".HDR");
    return header_name.substr(0, dot) + (upper ? ".IMG" : ".img");
}

}  // namespace openfab::texture
