// Preferences: reading, writing, and files that are broken.
#include "preferences.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "support/test_meshes.h"

namespace knead::studio::preferences_test {
namespace {

namespace fs = std::filesystem;

class PreferencesTest : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  LoadedPreferences load(const std::string& text) const {
    std::ofstream(folder_ / "studio.json", std::ios::trunc) << text;
    return load_preferences(folder_);
  }

  fs::path folder_ = fs::temp_directory_path() / fmt::format("knead_preferences_{}", ::getpid());
};

TEST_F(PreferencesTest, WithoutAFileEverythingIsAsByDefault) {
  const LoadedPreferences loaded = load_preferences(folder_ / "nothing");
  EXPECT_TRUE(loaded.messages.empty());
  EXPECT_EQ(loaded.preferences.keys, default_keys());
  EXPECT_EQ(loaded.preferences.navigation, NavigationPreset::blender);
}

TEST_F(PreferencesTest, WhatTheFileSaysIsUsed) {
  const LoadedPreferences loaded = load(
      R"({"keys": {"undo": ["Ctrl+Z", "Y"], "help": "F1", "quit": null}, "navigation": "maya", "up": "z",
          "interface_scale": 1.5, "undo_memory_mb": 64})");
  EXPECT_TRUE(loaded.messages.empty());
  EXPECT_EQ(action_of(loaded.preferences.keys, {"Y", {}}), Action::undo);
  EXPECT_EQ(action_of(loaded.preferences.keys, {"H", {}}), std::nullopt);
  EXPECT_TRUE(loaded.preferences.keys.of(Action::quit).empty());
  EXPECT_EQ(loaded.preferences.navigation, NavigationPreset::maya);
  EXPECT_EQ(loaded.preferences.up, UpAxis::z);
  EXPECT_EQ(loaded.preferences.interface_scale, 1.5);
  EXPECT_EQ(loaded.preferences.undo_memory_mb, 64);
}

TEST_F(PreferencesTest, NothingInTheFileIsFatal) {
  const LoadedPreferences loaded = load(
      R"({"keys": {"undo": 3, "redo": ["F5", 7], "levitate": "L", "open": "Strg+O"}, "navigation": "cinema",
          "interface_scale": 100, "up": null, "colour": "red", "undo_memory_mb": -1})");
  EXPECT_EQ(loaded.messages.size(), 9U);
  for (const std::string& message : loaded.messages) EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_EQ(loaded.preferences.keys.of(Action::undo), default_keys().of(Action::undo));
  EXPECT_EQ(loaded.preferences.interface_scale, 1);
  EXPECT_EQ(load(R"({"keys": []})").messages.size(), 1U);
}

TEST_F(PreferencesTest, UnitPenAndRingsAreReadAndWritten) {
  LoadedPreferences loaded =
      load(R"({"unit": "mm", "pen_pressure": "radius", "outer_ring": "#102030", "inner_ring": "#FFffFF"})");
  EXPECT_TRUE(loaded.messages.empty());
  EXPECT_EQ(loaded.preferences.unit, LengthUnit::millimetre);
  EXPECT_EQ(loaded.preferences.pressure, PenPressure::radius);
  EXPECT_FLOAT_EQ(loaded.preferences.outer_ring.green, 0x20 / 255.0F);
  EXPECT_EQ(loaded.preferences.inner_ring, (render::Color{1, 1, 1, 1}));
  loaded.preferences.unit = LengthUnit::metre;
  save_preferences(folder_, loaded.preferences);
  const Preferences again = load_preferences(folder_).preferences;
  EXPECT_EQ(again.unit, LengthUnit::metre);
  EXPECT_EQ(again.pressure, PenPressure::radius);
  EXPECT_EQ(again.outer_ring, loaded.preferences.outer_ring);
  EXPECT_EQ(
      load(R"({"unit": "inch", "pen_pressure": 1, "outer_ring": "blue", "inner_ring": "#12345"})").messages.size(), 4U);
}

TEST_F(PreferencesTest, ABrokenFileIsKeptAside) {
  for (const std::string text : {"{\"keys\": ", "[1, 2]", "\xff\xfe"}) {
    const LoadedPreferences loaded = load(text);
    ASSERT_EQ(loaded.messages.size(), 1U);
    EXPECT_NE(loaded.messages[0].find("studio.json.broken"), std::string::npos) << loaded.messages[0];
    EXPECT_EQ(file_bytes(folder_ / "studio.json.broken"), text);
    EXPECT_FALSE(fs::exists(folder_ / "studio.json"));
  }
}

TEST_F(PreferencesTest, SavingKeepsWhatAPersonWrote) {
  Preferences preferences = load(R"({"keys": {"undo": "U", "levitate": "L"}, "mine": [1], "up": "z"})").preferences;
  preferences.navigation = NavigationPreset::maya;
  preferences.up = UpAxis::y;
  save_preferences(folder_, preferences);
  const LoadedPreferences loaded = load_preferences(folder_);
  EXPECT_EQ(loaded.preferences.keys, preferences.keys);
  EXPECT_EQ(loaded.preferences.navigation, NavigationPreset::maya);
  EXPECT_EQ(loaded.preferences.up, UpAxis::y);
  const std::string text = file_bytes(folder_ / "studio.json");
  EXPECT_NE(text.find("levitate"), std::string::npos);
  EXPECT_NE(text.find("mine"), std::string::npos);
  EXPECT_EQ(text.find("\"up\""), std::string::npos);
  save_preferences(folder_ / "new" / "folder", preferences);
  EXPECT_EQ(load_preferences(folder_ / "new" / "folder").preferences.navigation, NavigationPreset::maya);
}

TEST_F(PreferencesTest, PanelsComeBackAsTheyWereLeft) {
  Preferences preferences;
  preferences.panels = {false, false, true, 412.5, {"view", "history"}};
  save_preferences(folder_, preferences);
  const LoadedPreferences loaded = load_preferences(folder_);
  EXPECT_TRUE(loaded.messages.empty());
  EXPECT_EQ(loaded.preferences.panels, preferences.panels);
  save_preferences(folder_, {});
  EXPECT_EQ(file_bytes(folder_ / "studio.json").find("panels"), std::string::npos) << "as by default";
  const LoadedPreferences odd = load(R"({"panels": {"width": -3, "shown": "no", "labels": true, "colour": 1}})");
  EXPECT_EQ(odd.messages.size(), 3U);
  EXPECT_EQ(odd.preferences.panels.width, PanelState{}.width);
  EXPECT_TRUE(odd.preferences.panels.labels);
  EXPECT_EQ(load(R"({"panels": 3})").messages.size(), 1U);
}

TEST_F(PreferencesTest, TheWindowComesBackAsItWasLeft) {
  Preferences preferences;
  preferences.window = {1000, 700, true};
  save_preferences(folder_, preferences);
  const LoadedPreferences loaded = load_preferences(folder_);
  EXPECT_TRUE(loaded.messages.empty());
  EXPECT_EQ(loaded.preferences.window, preferences.window);
  save_preferences(folder_, {});
  EXPECT_EQ(file_bytes(folder_ / "studio.json").find("window"), std::string::npos) << "as by default";
  const LoadedPreferences odd = load(R"({"window": {"width": -3, "height": 1e9, "maximized": 1}})");
  EXPECT_EQ(odd.messages.size(), 3U);
  EXPECT_EQ(odd.preferences.window, WindowPlace());
}

TEST_F(PreferencesTest, RecentFilesStandOnceTheLatestFirst) {
  std::vector<fs::path> recent;
  for (std::size_t i = 0; i < kMaxRecent + 3; ++i) {
    const fs::path file = folder_ / fmt::format("{}.ply", i);
    std::ofstream(file) << "x";
    add_recent(recent, file);
  }
  add_recent(recent, folder_ / "." / "5.ply");
  EXPECT_EQ(recent.size(), kMaxRecent);
  EXPECT_EQ(recent[0], folder_ / "5.ply");
  EXPECT_EQ(recent[1], folder_ / fmt::format("{}.ply", kMaxRecent + 2));
  save_recent(folder_, recent);
  EXPECT_EQ(load_recent(folder_), recent);
  fs::remove(recent[1]);
  recent.erase(recent.begin() + 1);
  EXPECT_EQ(load_recent(folder_), recent);
  std::ofstream(folder_ / "recent.json") << "[{";
  EXPECT_TRUE(load_recent(folder_).empty());
}

TEST_F(PreferencesTest, FoldersFollowTheStandard) {
  const char* const before = std::getenv("XDG_STATE_HOME");
  const std::string kept = before == nullptr ? "" : before;
  setenv("XDG_STATE_HOME", "/somewhere", 1);
  EXPECT_EQ(state_folder(), "/somewhere/knead");
  setenv("XDG_STATE_HOME", "not/absolute", 1);
  EXPECT_TRUE(state_folder().is_absolute());
  if (before != nullptr) {
    setenv("XDG_STATE_HOME", kept.c_str(), 1);
  } else {
    unsetenv("XDG_STATE_HOME");
  }
}

}  // namespace
}  // namespace knead::studio::preferences_test
