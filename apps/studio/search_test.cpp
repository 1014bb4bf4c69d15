#include "search.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace knead::studio {
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

TEST(Search, TitlesThatBeginWithTheTextComeFirst) {
  const std::vector<Action> found = found_actions("s");
  EXPECT_TRUE(title_of(found.front()).starts_with('S'));
  const auto inside = std::ranges::find(found, Action::history);
  const auto begins = std::ranges::find(found, Action::statistics);
  EXPECT_LT(begins, inside);
}

}  // namespace
}  // namespace knead::studio
