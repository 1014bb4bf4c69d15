// What the documents show must work: session lines can be read, links lead somewhere, and the example is applied.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "knead/knead.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "support/test_meshes.h"

namespace knead::documents_test {
namespace {

TEST(Documents, ShowOnlySessionLinesThatAreOnes) {
  int lines = 0;
  for (const char* name : {"README.md", "docs/guide.md", "docs/session.md", "docs/command.md"}) {
    std::istringstream text(file_bytes(std::filesystem::path(KNEAD_SOURCE) / name));
    std::string header = "{\"knead\": 1}";  // the last one that was shown: it has the parameters of lines after it
    for (std::string line; std::getline(text, line);) {
      const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
      line.erase(0, indent);
      if (indent >= 4 && line.starts_with("{\"knead\"")) header = line;
      if (indent < 4 || (!line.starts_with("{\"tool\"") && !line.starts_with("{\"mask\""))) continue;
      ++lines;
      EXPECT_NO_THROW(parse_session(header + "\n" + line + "\n", name)) << line;
    }
  }
  EXPECT_GT(lines, 30);
}

std::vector<std::filesystem::path> all_documents() {
  const std::filesystem::path root = KNEAD_SOURCE;
  std::vector<std::filesystem::path> documents{root / "README.md", root / "CHANGELOG.md", root / "CONTRIBUTING.md"};
  for (const char* folder : {"docs", "docs/decisions"}) {
    for (const auto& entry : std::filesystem::directory_iterator(root / folder)) {
      if (entry.path().extension() == ".md") documents.push_back(entry.path());
    }
  }
  return documents;
}

// The anchors of a page's headings, as GitHub makes them.
std::set<std::string> anchors_of(const std::filesystem::path& document) {
  std::set<std::string> anchors;
  std::istringstream text(file_bytes(document));
  for (std::string line; std::getline(text, line);) {
    if (line.empty() || line[0] != '#') continue;
    std::string anchor;
    for (const char c : line.substr(line.find_first_not_of("# "))) {
      if (c == ' ') anchor += '-';
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') {
        anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      }
    }
    anchors.insert(anchor);
  }
  return anchors;
}

TEST(Documents, EveryLinkLeadsToAFileAndAHeading) {
  const std::regex link(R"(\]\(([^)#:]*)(#([^)]*))?\))");
  int links = 0;
  for (const std::filesystem::path& document : all_documents()) {
    const std::string text = file_bytes(document);
    for (std::sregex_iterator it(text.begin(), text.end(), link); it != std::sregex_iterator(); ++it) {
      const std::filesystem::path target = (*it)[1].length() > 0 ? document.parent_path() / (*it)[1].str() : document;
      const std::string anchor = (*it)[3];
      ++links;
      EXPECT_TRUE(std::filesystem::exists(target)) << document << ": " << it->str();
      if (!anchor.empty()) {
        EXPECT_EQ(anchors_of(target).count(anchor), 1u) << document << ": " << it->str();
      }
    }
  }
  EXPECT_GT(links, 100);
}

// Code spans such as `knead/field.h`. Decisions and the changelog tell of the past.
TEST(Documents, EveryHeaderThatTheyNameExists) {
  const std::filesystem::path root = KNEAD_SOURCE;
  std::string headers;
  for (const char* folder : {"include", "src", "apps", "tests"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      headers += "/" + entry.path().generic_string() + "\n";
    }
  }
  const std::regex name("`([a-z_/]+\\.h)`");
  int names = 0;
  for (const std::filesystem::path& document : all_documents()) {
    if (document.filename() == "CHANGELOG.md" || document.parent_path().filename() == "decisions") continue;
    const std::string text = file_bytes(document);
    for (std::sregex_iterator it(text.begin(), text.end(), name); it != std::sregex_iterator(); ++it) {
      if ((*it)[1] == "foo.h") continue;  // any header
      ++names;
      EXPECT_NE(headers.find("/" + (*it)[1].str() + "\n"), std::string::npos) << document << ": " << it->str();
    }
  }
  EXPECT_GT(names, 40);
}

TEST(Documents, TheIndexNamesEveryDocument) {
  const std::string index = file_bytes(std::filesystem::path(KNEAD_SOURCE) / "docs/README.md");
  for (const std::filesystem::path& document : all_documents()) {
    const std::string name = document.filename().string();
    EXPECT_NE(index.find(name + ")"), std::string::npos) << document;
  }
}

TEST(Documents, AskForTheVersionOfThisProject) {
  const std::string version = KNEAD_VERSION;
  const std::string wanted = version.substr(0, version.rfind('.'));
  const std::string request = "find_package(knead ";
  int found = 0;
  for (const std::filesystem::path& document : all_documents()) {
    const std::string text = file_bytes(document);
    for (std::size_t at = text.find(request); at != std::string::npos; at = text.find(request, at + 1)) {
      ++found;
      EXPECT_TRUE(text.substr(at).starts_with(request + wanted + " ")) << document << ": not " << wanted;
    }
  }
  EXPECT_GT(found, 0);
}

TEST(Documents, TheExampleFoldsTwoFingersAndTheThumbOfTheHand) {
  const Mesh hand = make_shape(ShapeKind::hand);
  const Session session = read_session(std::filesystem::path(KNEAD_SOURCE) / "examples/peace.knead");
  EXPECT_TRUE(session.warnings.empty());
  const ReplayResult result = replay(hand, session);
  EXPECT_EQ(result.status, AdvectStatus::done);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
  EXPECT_NEAR(measure_volume_and_area(hand, result.shape.positions()).volume / measure(hand).volume, 1, 1e-4);
  for (const Finger& finger : hand_fingers()) {
    const Vec3d tip = finger.base + finger.axis * finger.length;
    double farthest = 0;
    for (std::size_t i = 0; i < hand.vertex_count(); ++i) {
      if (norm(hand.positions[i] - tip) > finger.radius) continue;
      farthest = std::fmax(farthest, norm(result.shape.positions()[i] - hand.positions[i]));
    }
    const bool holds = finger.name == "index" || finger.name == "middle";
    EXPECT_EQ(farthest < 0.05, holds) << finger.name << " moved by " << farthest;
    EXPECT_EQ(farthest > 0.2, !holds) << finger.name << " moved by " << farthest;
  }
}

}  // namespace
}  // namespace knead::documents_test
