// The strings of Studio are plain English: no word stands in them for which the project has another.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "document/document.h"
#include "keys.h"
#include "knead/editor/render.h"

namespace knead::studio::words_test {
namespace {

namespace fs = std::filesystem;

const fs::path kSources = KNEAD_SOURCES;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::vector<fs::path> files_under(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool is_test = name.find("_test") != std::string::npos || name.find("_fixture") != std::string::npos;
    if (entry.is_regular_file() && !is_test) files.push_back(entry.path());
  }
  return files;
}

// The string literals of a source; comments and includes are left out.
std::vector<std::string> strings_of(const std::string& source) {
  static const std::regex pattern(R"re(//[^\n]*|#include[^\n]*|"((?:[^"\\\n]|\\.)*)")re");
  std::vector<std::string> strings;
  for (auto it = std::sregex_iterator(source.begin(), source.end(), pattern); it != std::sregex_iterator(); ++it) {
    if ((*it)[1].matched) strings.push_back((*it)[1]);
  }
  return strings;
}

// Words with a better one beside them, and turns of phrase that must be read twice.
const std::regex& retired() {
  static const std::regex pattern(
      R"(\b(cards?|devices?|marks?|marked|barrels?|limbs?|proofs?|bench|ways?|desks?|trails?|ahead|companions?|)"
      R"(usual|usually|shadows?|hopeless|by (it|them)self|by themselves|the hand|a hand would|what the result is|)"
      R"(what it was|whether it did|gone on with|goes on with|where that can be|is told|are told|put away|)"
      R"(tak(e|es|en) (it|them)? ?away|found automatically)\b)",
      std::regex::icase);
  return pattern;
}

// Names that files and scripts of version 0.1 use, and one label.
const std::set<std::string> kAllowed{"marks", "mark", "tool_marks", "whole_limb", "barrel", "Automatic limb"};

TEST(Words, NoRetiredWordStandsInTheStringsOfStudio) {
  std::size_t count = 0;
  for (const fs::path& file : files_under(kSources / "apps/studio")) {
    if (file.extension() != ".cpp" && file.extension() != ".h") continue;
    for (const std::string& text : strings_of(text_of(file))) {
      ++count;
      if (kAllowed.contains(text)) continue;
      EXPECT_FALSE(std::regex_search(text, retired())) << file << ": " << text;
    }
  }
  EXPECT_GT(count, 500u) << "the sources were read";
}

TEST(Words, NoRetiredWordStandsInWhatIsInstalledBesideStudio) {
  for (const char* name : {"knead-studio.desktop", "knead.xml"}) {
    const std::string text = text_of(kSources / "share" / name);
    EXPECT_FALSE(text.empty()) << name;
    EXPECT_FALSE(std::regex_search(text, retired())) << name;
  }
}

// The messages about a setting that is not known send readers there.
TEST(Words, TheDocumentationListsEveryActionAndMatcap) {
  const std::string page = text_of(kSources / "docs/command.md");
  for (const Action action : all_actions()) {
    const std::string name(tool_of(action) == nullptr ? name_of(action) : "tool_");
    EXPECT_NE(page.find("`" + name + "`"), std::string::npos) << name;
  }
  for (const render::Matcap matcap : render::all_matcaps()) {
    const std::string name(render::name_of(matcap));
    EXPECT_NE(page.find("`" + name + "`"), std::string::npos) << name;
  }
}

// Whatever the library says about a stroke, no key of a session is shown.
TEST(Words, NoKeyOfASessionStandsInWhatStudioSaysAboutAStroke) {
  EXPECT_EQ(in_words("\"radius\": two pins are 3 apart; make \"radius\" larger"),
            "Two pins are 3 apart; make the radius larger.");
  EXPECT_EQ(in_words("\"inner\" is 0.9 of \"outer\": make \"outer\" larger"),
            "The inner part is 0.9 of the radius make the radius larger.");
  EXPECT_EQ(in_words("make the mask's \"width\" larger"), "Make the mask's border larger.");
  EXPECT_EQ(in_words("triangles of \"radius\" 3; use \"radius\": 4, the nearest"),
            "Triangles of the radius 3; use the radius 4, the nearest.");
  const std::regex format(R"re("[a-z_]+"|[a-z]_[a-z]|\{"|exact"|max_edge|detail")re");
  std::size_t count = 0;
  for (const char* folder : {"src/strokes", "src/pose", "src/remesh", "src/session", "src/skin", "src/flow"}) {
    for (const fs::path& file : files_under(kSources / folder)) {
      if (file.extension() != ".cpp") continue;
      for (std::string text : strings_of(text_of(file))) {
        text = std::regex_replace(text, std::regex(R"(\\")"), "\"");
        if (text.find("\" ") == std::string::npos || text.find(' ') == std::string::npos) continue;
        ++count;
        const std::string said = in_words(text);
        EXPECT_FALSE(std::regex_search(said, format)) << file << ": " << said;
      }
    }
  }
  EXPECT_GT(count, 60u);
}

TEST(Words, TheTestFindsWhatItLooksFor) {
  const auto strings = strings_of(R"src(f("plain"); // "One limb, found by itself"
g("the \"other\" way"))src");
  ASSERT_EQ(strings.size(), 2u);
  EXPECT_FALSE(std::regex_search(strings[0], retired()));
  EXPECT_TRUE(std::regex_search(strings[1], retired()));
  for (const char* old : {"One limb, found by itself", "Take them away", "Work that was not put away"}) {
    EXPECT_TRUE(std::regex_search(std::string(old), retired())) << old;
  }
}

}  // namespace
}  // namespace knead::studio::words_test
