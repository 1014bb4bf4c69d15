// Keys and actions: names, chords, settings, and the search of commands.
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "keys.h"

namespace knead::studio::keys_test {

namespace {

Action action(std::size_t i) { return static_cast<Action>(i); }

TEST(Keys, EveryChordReadsBackAsWhatItIsCalled) {
  for (const std::string_view key : key_names()) {
    for (int held = 0; held < 8; ++held) {
      const Chord chord{std::string(key), {(held & 1) != 0, (held & 2) != 0, (held & 4) != 0}};
      EXPECT_EQ(chord_of(text_of(chord)), chord) << text_of(chord);
    }
  }
  EXPECT_EQ(text_of({"Z", {true, true, false}}), "Ctrl+Shift+Z");
  EXPECT_EQ(chord_of("shift+ctrl+numpad +"), (Chord{"Numpad +", {true, true, false}}));
  EXPECT_EQ(chord_of("Ctrl+"), std::nullopt);
  EXPECT_EQ(chord_of("Hyper+X"), std::nullopt);
  EXPECT_EQ(chord_of(""), std::nullopt);
}

TEST(Keys, ByDefaultEveryActionHasAKeyOfItsOwn) {
  const KeyMap keys = default_keys();
  std::set<std::string> seen;
  for (std::size_t i = 0; i < all_actions().size(); ++i) {
    EXPECT_FALSE(keys.of(action(i)).empty()) << name_of(action(i));
    for (const Chord& chord : keys.of(action(i))) {
      EXPECT_TRUE(seen.insert(text_of(chord)).second) << text_of(chord);
      EXPECT_EQ(action_of(keys, chord), action(i));
    }
  }
  EXPECT_EQ(action_of(keys, {"Z", {false, true, false}}), Action::undo);
  EXPECT_EQ(action_of(keys, {"Z", {}}), std::nullopt);
  EXPECT_EQ(keys_text(keys, Action::help), "H or F1");
}

TEST(Keys, ActionsAreFoundByTheirNames) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < all_actions().size(); ++i) {
    EXPECT_EQ(action_named(name_of(action(i))), action(i));
    EXPECT_FALSE(title_of(action(i)).empty());
    EXPECT_FALSE(group_of(action(i)).empty());
    names.insert(name_of(action(i)));
  }
  EXPECT_EQ(names.size(), all_actions().size());
  EXPECT_EQ(action_named("levitate"), std::nullopt);
}

TEST(Keys, TwoActionsCanSwapTheirKeys) {
  KeyMap keys = default_keys();
  const std::vector<KeyChoice> choices{{"wireframe", {"S"}}, {"shading", {"W"}}};
  EXPECT_TRUE(choose_keys(keys, choices).empty());
  EXPECT_EQ(action_of(keys, {"S", {}}), Action::wireframe);
  EXPECT_EQ(action_of(keys, {"W", {}}), Action::shading);
}

TEST(Keys, WhatCannotBeUsedIsToldAndTheRestIsUsed) {
  KeyMap keys = default_keys();
  const std::vector<KeyChoice> choices{
      {"levitate", {"L"}}, {"undo", {"Strg+Z", "Y"}}, {"redo", {"Y", "Ctrl+Y"}}, {"open", {"W"}}, {"quit", {}}};
  const std::vector<std::string> messages = choose_keys(keys, choices);
  ASSERT_EQ(messages.size(), 4U);
  EXPECT_NE(messages[0].find("levitate"), std::string::npos);
  EXPECT_NE(messages[1].find("Strg+Z"), std::string::npos);
  EXPECT_NE(messages[2].find("both \"undo\" and \"redo\""), std::string::npos) << messages[2];
  EXPECT_NE(messages[3].find("away from \"wireframe\""), std::string::npos) << messages[3];
  EXPECT_EQ(action_of(keys, {"Y", {}}), Action::undo);
  EXPECT_EQ(action_of(keys, {"Y", {false, true, false}}), Action::redo);
  EXPECT_EQ(action_of(keys, {"W", {}}), Action::open);
  EXPECT_TRUE(keys.of(Action::quit).empty());
  EXPECT_EQ(action_of(keys, {"Z", {false, true, false}}), std::nullopt);
}

}  // namespace

namespace {

bool holds(const std::vector<Action>& actions, Action action) {
  return std::ranges::find(actions, action) != actions.end();
}

TEST(Search, EveryCommandIsFoundByItsTitleAndNothingIsFoundTwice) {
  for (const Action action : all_actions()) {
    EXPECT_TRUE(holds(found_actions(title_of(action)), action)) << title_of(action);
  }
  EXPECT_EQ(found_actions("").size(), all_actions().size());
  EXPECT_EQ(found_actions("   ").size(), all_actions().size());
}

TEST(Search, WordsCountInAnyOrderAndCase) {
  EXPECT_EQ(found_actions("WIREF").front(), Action::wireframe);
  EXPECT_EQ(found_actions("as save").front(), Action::save_as);
  EXPECT_TRUE(holds(found_actions("tools mirror"), Action::mirror_y)) << "by its group";
  EXPECT_TRUE(found_actions("save levitate").empty());
}

TEST(Search, KnowsTheWordsOfOtherPrograms) {
  constexpr std::array<std::array<const char*, 2>, 16> words{{{"relax", "smooth"},
                                                              {"blur", "smooth"},
                                                              {"scrape", "flatten"},
                                                              {"grab", "move"},
                                                              {"tentacle", "snakehook"},
                                                              {"extrude", "ball"},
                                                              {"clay", "paint"},
                                                              {"layer", "paint"},
                                                              {"wrinkle", "crease"},
                                                              {"sharpen", "pinch"},
                                                              {"alpha", "print"},
                                                              {"text", "print"},
                                                              {"spline", "bend_along"},
                                                              {"wrap", "bend_along"},
                                                              {"resize", "stretch"},
                                                              {"armature", "pose"}}};
  for (const auto& [word, tool] : words) {
    EXPECT_TRUE(holds(found_actions(word), action_of(*studio_tool(tool)))) << word;
  }
}

TEST(Search, TitlesThatBeginWithTheTextComeFirst) {
  const std::vector<Action> found = found_actions("s");
  EXPECT_TRUE(title_of(found.front()).starts_with('S'));
  const auto inside = std::ranges::find(found, Action::history);
  const auto begins = std::ranges::find(found, Action::statistics);
  EXPECT_LT(begins, inside);
}

}  // namespace

}  // namespace knead::studio::keys_test
