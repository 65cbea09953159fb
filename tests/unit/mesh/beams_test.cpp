// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Files of beams: text, arrays, lattices of 3MF.

#include "mesh/load/load_beams.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "base/messages.h"
#include "mesh/read/beams_npz.h"
#include "mesh/read/beams_text.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_beams.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMemory = 1 << 26;

std::string problem(const std::string& text) {
    const Result<ReadBeams> read = parse_beams(text, "a.txt", kMemory);
    if (read) return "";
    std::string said = read.error().text();
    if (!read.error().help.empty() && said.find(read.error().help) == std::string::npos)
        said += "; " + read.error().help;
    return said;
}

std::string bytes_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    return all.str();
}

TEST(BeamsText, ReadsNodesStrutsBallsAndAttributes) {
    const Result<ReadBeams> read =
        parse_beams(bytes_of("tests/fuzz/corpus/beams/truss.txt"), "truss.txt", kMemory);
    ASSERT_TRUE(read) << read.error().text();
    const Beams& beams = read->beams;
    ASSERT_EQ(beams.nodes.size(), 4u);
    ASSERT_EQ(beams.beams.size(), 7u);
    EXPECT_EQ(beams.nodes[2], (Vec3d{5, 8.66, 0}));
    EXPECT_EQ(beams.beams[3].radii, (std::array<float, 2>{1, 0.5f}));
    EXPECT_EQ(beams.beams[5].radii, (std::array<float, 2>{1, 0.5f}));
    EXPECT_EQ(beams.beams[6].nodes, (std::array<int32_t, 2>{3, 3}));
    ASSERT_EQ(beams.attributes.size(), 3u);
    EXPECT_EQ(beams.attributes[0].values, (std::vector<float>{20, 40, 60, 80}));
    EXPECT_EQ(beams.attributes[1].components, 3);
    EXPECT_EQ(beams.attributes[2].ints, (std::vector<int32_t>{1, 1, 1, 2, 2, 2, 3}));
    EXPECT_TRUE(read->warnings.empty());
}

TEST(BeamsText, SaysWhatIsWrongAndWhere) {
    const std::string two = "node 0 0 0 1\nnode 5 0 0 1\n";
    EXPECT_EQ(problem(two + "strut 0 2"), "a.txt:3:1: " + fmt::format(messages::kNoSuchNode, 2, 2) +
                                              "; " + messages::kNodesCountFromZero);
    EXPECT_THAT(
        problem(two + "strut 0 x"),
        ::testing::HasSubstr("a.txt:3:1: " + fmt::format(openfab::messages::kNotANumber, "x")));
    EXPECT_THAT(problem(two + "strut 0"), testing::Says(messages::kStrutNumbers, 1));
    EXPECT_THAT(problem(two + "strut 1 1"),
                ::testing::AllOf(testing::Says(messages::kStrutJoinsItself, 1),
                                 testing::Says(messages::kStrutJoinsItselfHelp, 1)));
    EXPECT_THAT(problem(two + "srut 0 1"), testing::Says(messages::kLineBeginsWith, "srut"));
    EXPECT_THAT(problem(two + "strut 0 1.5"), testing::Says(messages::kNoNumberOfNode, "1.5"));
    EXPECT_THAT(problem("node 0 0 0"), testing::Says(messages::kNodeNumbers, 3));
    EXPECT_THAT(problem("node 0 0 0 -1"), testing::Says(messages::kRadiusWrong, "-1*"));
    EXPECT_THAT(problem("node 0 0 2e6 1"), testing::Says(messages::kNodeLiesTooFar, "*", "1e+06"));
    EXPECT_THAT(problem("node 0 0 0 0\nnode 1 0 0 0\nstrut 0 1"),
                ::testing::AllOf(::testing::HasSubstr("a.txt:3:1: "),
                                 testing::Says(messages::kAStrutWithoutRadius)));
    EXPECT_THAT(problem(two), testing::Says(messages::kNoStrutNoBall));
    EXPECT_THAT(problem(""), testing::Says(messages::kNoStrutNoBall));
    EXPECT_THAT(problem(two + "attribute heat float"),
                testing::Says(messages::kAttributeAfterNode));
    EXPECT_THAT(problem("attribute heat double"),
                testing::Says(messages::kAttributeOfType, "double"));
    EXPECT_THAT(problem("attribute heat float\nnode 0 0 0 1"),
                testing::Says(messages::kNodeNumbersAttributesHelp, 5));
    EXPECT_THAT(problem("attribute k int\n" + two + "strut 0 1 0.5"),
                testing::Says(messages::kAttributeNotWholeNumber, "0.5", "k"));
    EXPECT_FALSE(parse_beams(two + "strut 0 1", "a.txt", 200));
}

TEST(BeamsText, StrutsEndAsTheLineBeforeThemSays) {
    const Result<ReadBeams> read =
        parse_beams(bytes_of("tests/fuzz/corpus/beams/ends.txt"), "ends.txt", kMemory);
    ASSERT_TRUE(read) << read.error().text();
    using enum BeamEnd;
    const std::array<std::array<BeamEnd, 2>, 5> wanted{
        {{kBall, kBall}, {kFlat, kDome}, {kFlat, kDome}, {kBall, kBall}, {kBall, kBall}}};
    ASSERT_EQ(read->beams.beams.size(), wanted.size());
    for (size_t i = 0; i < wanted.size(); ++i)
        EXPECT_EQ(read->beams.beams[i].ends, wanted[i]) << i;
    EXPECT_THAT(problem("ends round"),
                ::testing::AllOf(testing::Says(messages::kStrutEnds, "round"),
                                 testing::Says(messages::kStrutEndsHelp)));
    EXPECT_THAT(problem("ends"), testing::Says(messages::kStrutEnds));
    EXPECT_THAT(problem("ends ball flat"),
                ::testing::AllOf(::testing::HasSubstr("a.txt:1:1: "),
                                 testing::Says(messages::kBothStrutEnds)));
    EXPECT_THAT(problem("ends flat flat flat"), testing::Says(messages::kBothStrutEndsHelp));
}

TEST(BeamsText, TellsOfNodesThatNothingUses) {
    const Result<ReadBeams> read =
        parse_beams("node 0 0 0 1\nnode 5 0 0 1\nnode 9 9 9 1\nstrut 1 0", "a.txt", kMemory);
    ASSERT_TRUE(read);
    ASSERT_EQ(read->warnings.size(), 1u);
    EXPECT_THAT(read->warnings[0],
                testing::Says(messages::kNodesWithoutStrutFirst, "*", "*1", 3, 2));
}

TEST(BeamsNpz, ReadsArrays) {
    const Result<ReadBeams> text =
        parse_beams(bytes_of("tests/fuzz/corpus/beams/truss.txt"), "truss.txt", kMemory);
    const Result<ReadBeams> read =
        parse_beams_npz(bytes_of("tests/fuzz/corpus/npz/truss.npz"), "truss.npz", kMemory);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_TRUE(text);
    EXPECT_EQ(read->beams.nodes, text->beams.nodes);
    ASSERT_EQ(read->beams.beams.size(), 7u);
    for (size_t i = 0; i < 7; ++i) {
        EXPECT_EQ(read->beams.beams[i].nodes, text->beams.beams[i].nodes);
        EXPECT_EQ(read->beams.beams[i].radii, text->beams.beams[i].radii);
    }
    ASSERT_EQ(read->beams.attributes.size(), 3u);  // in the order of their names
    EXPECT_EQ(read->beams.attributes[0].name, "color");
    EXPECT_EQ(read->beams.attributes[1].values, text->beams.attributes[0].values);
    EXPECT_EQ(read->beams.attributes[2].ints, text->beams.attributes[2].ints);
    const Result<ReadBeams> ends =
        parse_beams_npz(bytes_of("tests/fuzz/corpus/npz/ends.npz"), "ends.npz", kMemory);
    ASSERT_TRUE(ends) << ends.error().text();
    EXPECT_EQ(ends->beams.beams[6].radii[1], 1.0f);
}

std::string lattice(const std::string& attributes, const std::string& inside,
                    const std::string& more = "") {
    const std::string mesh =
        R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="10" y="0" z="0"/><vertex x="0" y="10" z="0"/></vertices><triangles/>)"
        R"(<b:beamlattice )" +
        attributes + ">" + inside + "</b:beamlattice></mesh>";
    return threemf_package(threemf_model(
        R"(<object id="1" name="net">)" + mesh + "</object>" + more,
        R"(<item objectid="1" transform="2 0 0 0 2 0 0 0 2 0 0 5"/>)",
        R"(xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" requiredextensions="b")"));
}

TEST(BeamLattice, ReadsBeamsCapsBallsAndSets) {
    const Result<ReadThreemfBeams> read = parse_threemf_beams(
        lattice(
            R"(radius="1" minlength="0.01" clippingmode="inside" clippingmesh="7" ballmode="mixed" ballradius="3")",
            R"(<b:beams><b:beam v1="0" v2="1"/><b:beam v1="0" v2="2" r1="2" r2="1"/>)"
            R"(<b:beam v1="1" v2="2" cap1="butt" cap2="hemisphere"/></b:beams>)"
            R"(<b:balls><b:ball vindex="1"/></b:balls>)"
            R"(<b:beamsets><b:beamset name="s"><b:ref index="1"/></b:beamset></b:beamsets>)"),
        "a.3mf", kMemory);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->lattices.size(), 1u);
    const ThreemfBeams& net = read->lattices[0];
    EXPECT_EQ(net.name, "net");
    const std::vector<Beam>& beams = net.beams.beams;
    // A capsule; a cone with domes and two balls; a cut beam; the listed ball.
    ASSERT_EQ(beams.size(), 6u);
    EXPECT_EQ(beams[0].ends[0], BeamEnd::kBall);
    EXPECT_EQ(beams[0].radii[0], 2.0f);  // twice as large
    EXPECT_EQ(net.beams.nodes[1], (Vec3d{20, 0, 5}));
    EXPECT_EQ(beams[1].ends[1], BeamEnd::kDome);
    EXPECT_EQ(beams[2].nodes[0], beams[2].nodes[1]);
    EXPECT_EQ(beams[2].radii[0], 4.0f);
    EXPECT_EQ(beams[4].ends, (std::array{BeamEnd::kFlat, BeamEnd::kDome}));
    EXPECT_EQ(beams[5].radii[0], 6.0f);
    EXPECT_EQ(net.beams.attributes[0].ints, (std::vector<int32_t>{0, 1, 1, 1, 0, 0}));
    ASSERT_EQ(read->left_out.size(), 1u);
    EXPECT_THAT(read->left_out[0].what, testing::Says(messages::kMeshThatClips, "inside"));
    // As drafts of the extension spell it.
    const Result<ReadThreemfBeams> draft = parse_threemf_beams(
        lattice(R"(radius="1" minlength="0.01" clipping="outside" clippingmesh="7")",
                R"(<b:beams><b:beam v1="0" v2="1"/></b:beams>)"),
        "a.3mf", kMemory);
    ASSERT_TRUE(draft) << draft.error().text();
    ASSERT_EQ(draft->left_out.size(), 1u);
    EXPECT_THAT(draft->left_out[0].what, testing::Says(messages::kMeshThatClips, "outside"));
}

std::string lattice_problem(const std::string& bytes) {
    const Result<ReadBeams> read = parse_threemf_beams(bytes, "a.3mf", "", kMemory);
    return read ? "" : read.error().text();
}

TEST(BeamLattice, SaysWhatIsWrong) {
    const std::string beam = R"(<b:beams><b:beam v1="0" v2="1"/></b:beams>)";
    EXPECT_EQ(lattice_problem(lattice(R"(radius="1" minlength="0")", beam)), "");
    EXPECT_THAT(lattice_problem(lattice(R"(radius="0" minlength="0")", beam)),
                testing::Says(messages::kBeamWithoutRadius));
    EXPECT_THAT(
        lattice_problem(lattice(R"(radius="1")", R"(<b:beams><b:beam v1="0" v2="9"/></b:beams>)")),
        testing::Says(messages::kBeamOfNoVertex, 9, 3));
    EXPECT_NE(lattice_problem(lattice(R"(radius="1" cap="round")", beam)).find("`cap` is `round`"),
              std::string::npos);
    EXPECT_THAT(lattice_problem(lattice(R"(radius="1" clippingmode="some")", beam)),
                testing::Says(messages::kClippingMode));
    EXPECT_THAT(lattice_problem(lattice(R"(radius="1" minlength="100")", beam)),
                testing::Says(messages::kNoLatticePlaced));
    std::string stretched = lattice(R"(radius="1")", beam);
    EXPECT_THAT(
        lattice_problem(threemf_package(threemf_model(
            R"(<object id="1">)" + threemf_cube(0, 1) + "</object>", R"(<item objectid="1"/>)"))),
        testing::Says(messages::kNoLatticePlaced));
}

}  // namespace
}  // namespace openfab::mesh
