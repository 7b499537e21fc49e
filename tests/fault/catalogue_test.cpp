#include "fault/catalogue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "bench.hpp"
#include "configuration/configuration.hpp"
#include "fault_words/document.hpp"
#include "support/paths.hpp"

namespace servohil::fault {
namespace {

using model::Parameters;
using testing::Full;
using testing::Under;
using testing::UnsupportedBy;
using testing::WithStabilizer;

TEST(Catalogue, NamesAndNumbersAreUnique) {
  std::set<std::string> names;
  std::set<int> numbers;
  for (const Spec& spec : Catalogue()) {
    EXPECT_TRUE(names.insert(spec.name).second) << spec.name;
    EXPECT_TRUE(numbers.insert(spec.id).second) << spec.name;
    EXPECT_EQ(Find(spec.id), &spec);
    EXPECT_NE(spec.id, 0) << "0 is no fault";
  }
  EXPECT_EQ(Find(0), nullptr);
}

TEST(Catalogue, TellsOfEachParameterWhatAnOperatorNeeds) {
  for (const Spec& spec : Catalogue()) {
    EXPECT_EQ(std::string(spec.effect).back(), '.') << spec.name;
    bool ended = false;
    for (const ParameterSpec& p : spec.parameters) {
      ended = ended || p.name == nullptr;
      if (p.name == nullptr) continue;
      const std::string where = std::string(spec.name) + " " + p.name;
      EXPECT_FALSE(ended) << where << ": after one that is not there";
      EXPECT_LT(p.minimum, p.maximum) << where;
      EXPECT_GE(p.preset, p.minimum) << where;
      EXPECT_LE(p.preset, p.maximum) << where;
      EXPECT_STRNE(p.meaning, "") << where;
    }
  }
}

TEST(Catalogue, PartsStandTogether) {
  for (std::size_t i = 1; i < Catalogue().size(); ++i)
    EXPECT_GE(Catalogue()[i].part, Catalogue()[i - 1].part);
}

TEST(Catalogue, NothingOfAFaultLeavesTheParametersToTheLastBit) {
  Parameters p = testing::WithStabilizer();
  p.oil.name = model::OilName::kIsoVg32;
  p.supply.drain_pressure_psi = 0.3;
  p.friction = {.coulomb_psi = 3.1, .closing_ratio = 0.7};
  p.load.closing = p.load.opening.Shifted(-7.3);
  p.load.has_closing = true;
  for (const Spec& spec : Catalogue()) {
    const ParameterAct* act = std::get_if<ParameterAct>(&spec.act);
    if (act == nullptr) continue;
    Parameters same = p;
    (*act)(same, testing::Of(spec.name).values, 0.0, 0.037);
    EXPECT_EQ(std::memcmp(&same, &p, sizeof p), 0) << spec.name;
  }
}

TEST(Catalogue, AFaultThatThesisPhysicsIsSaidToHaveHasAnEffectThere) {
  for (const Spec& spec : Catalogue()) {
    Parameters p = testing::WithStabilizer();
    p.physics = model::Physics::kThesis;
    if (!spec.ActsAs<ParameterAct>() || testing::UnsupportedBy(spec, p) != nullptr) continue;
    testing::Bench with(p);
    testing::Bench without(p);
    with.Inject(spec.name);
    for (testing::Bench* bench : {&with, &without}) bench->Run(20), bench->p1_psi += 0.5, bench->Run(20);
    EXPECT_NE(with.State().Vector(), without.State().Vector()) << spec.name;
  }
}

TEST(Catalogue, WhatTheModelDoesNotHaveIsRefused) {
  Parameters thesis = testing::Full();
  thesis.physics = model::Physics::kThesis;
  EXPECT_STREQ(testing::UnsupportedBy(testing::Named("air_entrainment"), thesis),
               "model.physics = \"thesis\" does not have what it acts on");
  EXPECT_EQ(testing::UnsupportedBy(testing::Named("air_entrainment"), testing::Full()), nullptr);
  EXPECT_STREQ(testing::UnsupportedBy(testing::Named("gas_charge_lost"), testing::Full()),
               "stabilizer.enabled is false");
  EXPECT_EQ(testing::UnsupportedBy(testing::Named("gas_charge_lost"), testing::WithStabilizer()), nullptr);
}

/// Keys that a fault takes where no configuration does, on purpose.
const std::set<std::string> kBeyond = {
    "supply_loss supply.pressure_psi",
    "supply_sag supply.pressure_psi",
    "piston_jammed friction.coulomb_psi",
    "relay_piston_stuck servo.relay_piston_stroke_in",
    "plunger_stuck servo.main_spring_rate_lbf_in",
    "plunger_stuck servo.main_spring_preload_lbf",
    "gas_charge_lost stabilizer.precharge_psi",
    "diaphragm_ruptured stabilizer.precharge_psi",
};

/// Of each parameter its range's ends.
std::vector<std::vector<double>> Corners(const Spec& spec) {
  std::vector<std::vector<double>> corners = {{}};
  for (const ParameterSpec& p : spec.parameters) {
    if (p.name == nullptr) break;
    std::vector<std::vector<double>> more;
    for (const auto& corner : corners) {
      for (double end : {p.minimum, p.maximum}) more.push_back(corner), more.back().push_back(end);
    }
    corners = more;
  }
  return corners;
}

TEST(Catalogue, AFaultLeavesTheParametersWhereAConfigurationMayHaveThem) {
  for (const Spec& spec : Catalogue()) {
    if (!spec.ActsAs<ParameterAct>()) continue;
    for (const auto& corner : Corners(spec)) {
      configuration::Configuration faulted;
      faulted.model = testing::Under(testing::WithStabilizer(), spec.name, corner);
      for (const configuration::Key& key : configuration::KeyTable()) {
        const auto* place = std::get_if<double& (*)(configuration::Configuration&)>(&key.place);
        if (place == nullptr || !(key.minimum < key.maximum)) continue;
        const std::string what = std::string(spec.name) + " " + key.name;
        if (kBeyond.count(what) != 0) continue;
        EXPECT_GE((*place)(faulted), key.minimum) << what;
        EXPECT_LE((*place)(faulted), key.maximum) << what;
      }
    }
  }
}

TEST(FaultDocument, HasAPictureOfEachFault) {
  const std::filesystem::path pictures = servohil::testing::SourceFile(".github/pictures/faults");
  std::set<std::string> drawn;
  std::uintmax_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator(pictures)) {
    drawn.insert(file.path().stem());
    bytes += file.file_size();
  }
  std::set<std::string> expected;
  for (const Spec& spec : Catalogue()) {
    // Those of a protected message or of error frames have nothing that could be seen in values over time.
    if (spec.needs != Needs::kCounter && spec.needs != Needs::kChecksum && spec.needs != Needs::kErrorFrames)
      expected.insert(spec.name);
  }
  EXPECT_EQ(drawn, expected) << "tools/draw_faults.py";
  EXPECT_LT(bytes, 1'500'000U);
}

TEST(FaultDocument, IsWhatTheCatalogueSays) {
  std::ifstream file(servohil::testing::SourceFile("FAULTS.md"));
  std::ostringstream committed;
  committed << file.rdbuf();
  EXPECT_EQ(committed.str(), fault_words::FaultDocument()) << "servohil fault list --markdown > FAULTS.md";
}

}  // namespace
}  // namespace servohil::fault
