// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Spectra of tables and of CxF, as programs write them, against colours that other programs compute of the
// same curves.

#include "tools/color/spectra.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/says/says.h"
#include "tools/color/messages.h"
#include "tools/color/samples.h"

namespace openfab::color {
namespace {

struct Curve {
    std::function<double(double nm)> reflected;
    Lab d50, d65;
};

/// Lab of the 1931 observer, relative to the light's white, by colour-science 0.4.7 (`sd_to_XYZ` of values
/// at 380 to 730 nm in steps of 10; Argyll's spec2cie 2.3.1 differs by 0.02 at most).
const std::vector<Curve>& curves() {
    static const std::vector<Curve> kCurves = {
        {[](double nm) { return 0.5 + 0.4 * std::sin((nm - 380) / 50); },
         {67.591, -27.526, -45.937},
         {68.943, -19.626, -43.621}},
        {[](double nm) { return 0.04 + 0.85 / (1 + std::exp(-(nm - 580) / 12)); },
         {63.521, 60.041, 68.262},
         {61.573, 57.035, 65.010}},
        {[](double nm) { return 0.06 + 0.7 * std::exp(-(nm - 460) * (nm - 460) / 1225); },
         {37.492, 25.715, -73.680},
         {38.796, 35.493, -71.173}},
        {[](double) { return 1.0; }, {100, 0, 0}, {100, 0, 0}},
    };
    return kCurves;
}

/// A CGATS table of the curves. `name` is of a column of a wavelength.
std::string table_of(const std::function<std::string(double nm)>& name, double unit,
                     double step = 10, const std::string& head = "", double last = 730) {
    std::string names = "SAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K", rows;
    for (double nm = 380; nm <= last + 1e-6; nm += step)
        names += " " + name(nm);
    for (size_t k = 0; k < curves().size(); ++k) {
        rows += fmt::format("{} {} 0 0 0", k + 1, 10 * k);
        for (double nm = 380; nm <= last + 1e-6; nm += step)
            rows += fmt::format(" {:.6f}", curves()[k].reflected(nm) * unit);
        rows += "\n";
    }
    return "CGATS.17\n" + head + "BEGIN_DATA_FORMAT\n" + names +
           "\nEND_DATA_FORMAT\nNUMBER_OF_SETS 4\nBEGIN_DATA\n" + rows + "END_DATA\n";
}

void expect_colours(const std::string& text, double near = 0.05) {
    for (const Light light : {Light::kD50, Light::kD65}) {
        const Result<SampleTable> table = parse_samples(text, {light, {}});
        ASSERT_TRUE(table) << table.error().text();
        EXPECT_TRUE(table->has_lab);
        ASSERT_EQ(table->samples.size(), curves().size());
        for (size_t k = 0; k < curves().size(); ++k) {
            const Lab& wanted = light == Light::kD50 ? curves()[k].d50 : curves()[k].d65;
            EXPECT_NEAR(table->samples[k].lab.l, wanted.l, near) << k;
            EXPECT_NEAR(table->samples[k].lab.a, wanted.a, near) << k;
            EXPECT_NEAR(table->samples[k].lab.b, wanted.b, near) << k;
            EXPECT_NEAR(table->samples[k].inks[0], 0.1 * static_cast<double>(k), 1e-9);
        }
    }
}

TEST(Spectra, OfAllNamesAndUnits) {
    const auto named = [](const char* form) {
        return [form](double nm) {
            return fmt::format(fmt::runtime(form), static_cast<int>(std::lround(nm)));
        };
    };
    for (const char* form : {"SPEC_{}", "SPECTRAL_NM{}", "SPECTRAL_NM_{}", "nm{}", "NM_{}", "{}nm",
                             "R_{}", "R{}", "{}", "spectral_{}", "SPECTRAL_PCT_{}"}) {
        SCOPED_TRACE(form);
        expect_colours(table_of(named(form), 100));
    }
    expect_colours(table_of(named("SPECTRAL_NM{}"), 1));
    expect_colours(table_of(named("SPECTRAL_DEC_{}"), 1));
    expect_colours(table_of(named("SPEC_{}"), 255, 10,
                            "SPECTRAL_BANDS \"36\"\nSPECTRAL_START_NM \"380.0\"\nSPECTRAL_END_NM "
                            "\"730.0\"\nSPECTRAL_NORM \"255\"\n"));
    expect_colours(table_of(named("nm{}"), 100, 5));
    // The high resolution of Argyll, whose names are rounded.
    expect_colours(table_of(named("SPEC_{}"), 100, 10.0 / 3,
                            "SPECTRAL_START_NM \"380.0\"\nSPECTRAL_END_NM \"730.0\"\n"));
    // In steps of 20 a slope of 12 nm is seen less well.
    expect_colours(table_of(named("nm{}"), 100, 20, "", 740), 0.6);
}

TEST(Spectra, CountBeforeColoursOfAnotherLight) {
    const auto name = [](double nm) { return fmt::format("SPEC_{}", std::lround(nm)); };
    std::string text = table_of(name, 1, 10, "ILLUMINATION_NAME \"D65\"\nOBSERVER \"10\"\n");
    text.replace(text.find(" SPEC_380"), 0, " LAB_L LAB_A LAB_B");
    for (size_t k = 0; k < 4; ++k) {
        const std::string row = fmt::format("\n{} {} 0 0 0", k + 1, 10 * k);
        text.replace(text.find(row) + row.size(), 0, " 1 2 3");
    }
    expect_colours(text);
}

TEST(Spectra, ThatCannotBeUsedAreRefused) {
    const auto refused = [](const std::string& text, Light light = Light::kD50) {
        const Result<SampleTable> table = parse_samples(text, {light, {}});
        return table ? std::string("it was taken") : table.error().text();
    };
    const auto name = [](double nm) { return fmt::format("nm{}", std::lround(nm)); };
    EXPECT_THAT(refused(table_of(name, 1, 10, "", 640)),
                testing::Says(messages::kSpectrumTooShort, "27", "380", "640"));
    EXPECT_THAT(refused(table_of(name, 1, 25, "", 755)),
                testing::Says(messages::kSpectrumTooShort, "16", "380", "755"));
    std::string twice = table_of(name, 1);
    twice.replace(twice.find("nm390"), 5, "nm380");
    EXPECT_THAT(refused(twice), testing::Says(messages::kWavelengthTwice, "nm380", "nm380"));
    std::string uneven = table_of(name, 1);
    uneven.replace(uneven.find("nm390"), 5, "nm396");
    EXPECT_THAT(refused(uneven), testing::Says(messages::kWavelengthsUneven, "nm396", "390"));
    EXPECT_THAT(
        refused("CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n0,0,0,0,1,2,3\n", Light::kD65),
        testing::Says(messages::kNoSpectra));
}

std::string cxf(const std::string& objects, const std::string& specifications) {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<cc:CxF "
           "xmlns:cc=\"http://colorexchangeformat.com/"
           "CxF3-core\"><cc:FileInformation><cc:Creator>a "
           "test</cc:Creator></cc:FileInformation><cc:Resources><cc:ObjectCollection>" +
           objects + "</cc:ObjectCollection><cc:ColorSpecificationCollection>" + specifications +
           "</cc:ColorSpecificationCollection></cc:Resources></cc:CxF>\n";
}

std::string inks_of(size_t k) {
    return fmt::format(
        "<cc:DeviceColorValues><cc:ColorCMYK><cc:Cyan>{}</cc:Cyan><cc:Magenta>0</cc:Magenta>"
        "<cc:Yellow>0</cc:Yellow><cc:Black>0</cc:Black></cc:ColorCMYK></cc:DeviceColorValues>",
        10 * k);
}

std::string spectrum_of(size_t k, const std::string& specification, double scale = 1,
                        const char* start = " StartWL=\"380\"") {
    std::string out =
        "<cc:ReflectanceSpectrum ColorSpecification=\"" + specification + "\"" + start + ">";
    for (double nm = 380; nm <= 730; nm += 10)
        out += fmt::format("{:.6f}\n ", curves()[k].reflected(nm) * scale);
    return out + "</cc:ReflectanceSpectrum>";
}

std::string object(size_t k, const std::string& inside, const char* type = "Standard") {
    return fmt::format("<cc:Object Id=\"o{0}\" ObjectType=\"{1}\" Name=\"{0}\">{2}</cc:Object>",
                       k + 1, type, inside);
}

std::string values(const std::string& inside) {
    return "<cc:ColorValues>" + inside + "</cc:ColorValues>";
}

std::string specification(const char* id, const char* condition, const char* light = "D50") {
    return fmt::format(
        "<cc:ColorSpecification Id=\"{0}\"><cc:TristimulusSpec><cc:Illuminant>{2}</cc:Illuminant>"
        "<cc:Observer>2_Degree</cc:Observer></cc:TristimulusSpec><cc:MeasurementSpec>"
        "<cc:WavelengthRange StartWL=\"380\" "
        "Increment=\"10\"/><cc:Device><cc:DeviceIllumination>{1}"
        "</cc:DeviceIllumination></cc:Device></cc:MeasurementSpec></cc:ColorSpecification>",
        id, condition, light);
}

TEST(Cxf, SpectraOfOneObjectOrOfSeveralGoWithTheirInks) {
    std::string one, by_name, by_order, other_names, percent;
    for (size_t k = 0; k < 4; ++k) {
        one += object(k, values(spectrum_of(k, "c", 1, "")) + inks_of(k));
        percent += object(k, values(spectrum_of(k, "c", 100)) + inks_of(k));
        by_name += object(3 - k, inks_of(3 - k), "Target");
        by_order += object(k, inks_of(k), "Target");
        other_names += object(k + 50, values(spectrum_of(k, "c")), "M0_Measurement");
    }
    for (size_t k = 0; k < 4; ++k)
        by_name += object(k, values(spectrum_of(k, "c")), "M1_Measurement");
    const std::string how = specification("c", "M1_Daylight");
    expect_colours(cxf(one, how));
    expect_colours(cxf(percent, how));
    expect_colours(cxf(by_order + other_names, how));
    const Result<SampleTable> named = parse_samples(cxf(by_name, how));
    ASSERT_TRUE(named) << named.error().text();
    for (const Sample& sample : named->samples)
        EXPECT_NEAR(sample.lab.l,
                    curves()[static_cast<size_t>(std::lround(sample.inks[0] * 10))].d50.l, 0.05);
}

TEST(Cxf, LabAndXyzAreOfD50) {
    const std::string lab = values(
        "<cc:ColorCIELab ColorSpecification=\"c\"><cc:L>50.5</cc:L><cc:A>-3.25</cc:A><cc:B>1e1"
        "</cc:B></cc:ColorCIELab>");
    const std::string xyz = values(
        "<cc:ColorCIEXYZ ColorSpecification=\"c\"><cc:X>96.42</cc:X><cc:Y>100</cc:Y><cc:Z>82.49"
        "</cc:Z></cc:ColorCIEXYZ>");
    const std::string d50 = specification("c", "M0"), d65 = specification("c", "M0", "D65");
    const Result<SampleTable> a = parse_samples(cxf(object(0, lab + inks_of(1)), d50));
    ASSERT_TRUE(a) << a.error().text();
    EXPECT_EQ(a->samples[0].lab.l, 50.5);
    EXPECT_EQ(a->samples[0].lab.a, -3.25);
    EXPECT_EQ(a->samples[0].lab.b, 10);
    const Result<SampleTable> b = parse_samples(cxf(object(0, xyz + inks_of(1)), d50));
    ASSERT_TRUE(b) << b.error().text();
    EXPECT_NEAR(b->samples[0].lab.l, 100, 1e-6);
    EXPECT_THAT(parse_samples(cxf(object(0, lab + inks_of(1)), d65)).error().text(),
                testing::Says(messages::kOtherLight, "D65"));
    EXPECT_THAT(
        parse_samples(cxf(object(0, lab + inks_of(1)), d50), {Light::kD65, {}}).error().text(),
        testing::Says(messages::kNoSpectra));
}

TEST(Cxf, OfSeveralConditionsOneCounts) {
    std::string all;
    for (size_t k = 0; k < 4; ++k)
        all += object(
            k, values(spectrum_of(k, "a", 0.5) + spectrum_of(k, "b", 0.75) + spectrum_of(k, "c")) +
                   inks_of(k));
    const std::string text =
        cxf(all, specification("a", "M2_UVExcluded") + specification("b", "M0_Incandescent") +
                     specification("c", "M1_Daylight"));
    expect_colours(text);
    EXPECT_THAT(parse_samples(text)->note,
                testing::Says(messages::kCxfChosen, "`M2`, `M0`, `M1`", "M1"));
    const Result<SampleTable> dark = parse_samples(text, {Light::kD50, "M2"});
    ASSERT_TRUE(dark);
    EXPECT_NEAR(dark->samples[3].lab.l, 116 * std::cbrt(0.5) - 16, 0.01);
    EXPECT_THAT(parse_samples(text, {Light::kD50, "M3"}).error().text(),
                testing::Says(messages::kCxfCondition, "M3", "`M2`, `M0`, `M1`"));
}

TEST(Cxf, SaysWhatIsWrongAndWhere) {
    const std::string how = specification("c", "M1");
    const auto refused = [&](const std::string& objects, const std::string& specifications) {
        const Result<SampleTable> table = parse_samples(cxf(objects, specifications));
        return table ? std::string("it was taken") : table.error().text();
    };
    EXPECT_THAT(parse_samples("<a/>").error().text(), testing::Says(messages::kNotCxf));
    EXPECT_THAT(refused(object(0, inks_of(0)), how), testing::Says(messages::kCxfNoObjects));
    EXPECT_THAT(refused(object(0, values(spectrum_of(0, "c"))), how),
                ::testing::HasSubstr("0 have amounts, 1 have colours"));
    EXPECT_THAT(refused(object(0, values(spectrum_of(0, "c", 1, "")) + inks_of(0)), ""),
                ::testing::HasSubstr("StartWL"));
    EXPECT_THAT(refused(object(0, values("<cc:ReflectanceSpectrum StartWL=\"380\">1 2 x"
                                         "</cc:ReflectanceSpectrum>") +
                                      inks_of(0)),
                        ""),
                ::testing::HasSubstr("object `1`: `x` are not numbers"));
    EXPECT_THAT(refused(object(0, values(spectrum_of(0, "c")) + inks_of(20)), how),
                ::testing::HasSubstr("200"));
    EXPECT_FALSE(parse_samples(cxf("", "").substr(0, 300)));
}

}  // namespace
}  // namespace openfab::color
