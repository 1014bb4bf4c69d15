// The document: refusals, kept parameters, and the numbers of an entry as fields.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "document/document.h"
#include "document/layers.h"
#include "support/memory_limit.h"
#include "support/sanitized.h"

namespace knead::studio::document_test {

namespace {

namespace fs = std::filesystem;

class DocumentOpenTest : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  DocumentOptions options() {
    DocumentOptions options;
    options.journals = folder_;
    options.show = [this](const DocumentState& state) { shown_ = state; };
    options.tell = [this](const Notice& notice) {
      if (notice.is_error) errors_ += notice.text + "\n";
    };
    return options;
  }

  // Opens a large sphere where so little memory is left, and returns the errors.
  std::string open_large(Document& document, rlim_t bytes) {
    errors_.clear();
    Progress progress;
    test::limit_memory(bytes);
    document.open_made(ShapeKind::sphere, 100'000, progress);
    test::lift_memory_limit();
    return errors_;
  }

  fs::path folder_ = fs::temp_directory_path() / ("knead_document_open_test_" + std::to_string(::getpid()));
  DocumentState shown_;
  std::string errors_;
};

SessionStroke pull() {
  ImplicitStroke stroke;
  stroke.path = {{0, 0, 1}, {0.2, 0.1, 1.2}};
  stroke.inner = 0.1;
  stroke.outer = 0.5;
  return {stroke};
}

// Of a drag that is refused, while it lasts and when it ends.
TEST_F(DocumentOpenTest, ARefusalIsOneSentenceSaidOnce) {
  Document document(options());
  Progress progress;
  document.open_made(ShapeKind::sphere, 2562, progress);
  PinsStroke stroke;
  stroke.points = {{0, 0, 1}, {0, 1, 0}};
  stroke.to = {{0, 0, 1}, {0, 0, 1}};
  stroke.radius = 0.5;
  errors_.clear();
  document.set_live({{stroke}}, progress);
  document.finish(progress);
  EXPECT_EQ(errors_.find("Pins 0 and 1 meet"), 0U) << errors_;
  EXPECT_EQ(errors_.find("1 meet"), errors_.rfind("1 meet")) << errors_;
  EXPECT_EQ(errors_.substr(errors_.size() - 2), ".\n") << errors_;
}

TEST_F(DocumentOpenTest, ShapeThatDoesNotFitLeavesTheDocument) {
  if (test::kSanitized) GTEST_SKIP() << "sanitizers need memory of their own";
  Document document(options());
  Progress progress;
  document.open_made(ShapeKind::sphere, 100'000, progress);  // starts the threads, which need memory too
  document.open_made(ShapeKind::sphere, 2562, progress);
  const std::vector<Vec3d> untouched = shown_.state.positions.copy();
  document.set_live({pull()}, progress);
  document.finish(progress);
  const std::vector<Vec3d> pulled = shown_.state.positions.copy();
  ASSERT_NE(pulled, untouched);
  int refused = 0;
  bool is_opened = false;
  for (rlim_t megabytes = 1; !is_opened && megabytes < 1000; megabytes += 2) {
    const std::string errors = open_large(document, megabytes << 20);
    is_opened = errors.empty();
    if (is_opened) continue;
    ++refused;
    ASSERT_NE(errors.find("not enough memory"), std::string::npos) << errors;
    ASSERT_EQ(shown_.opened, 2U) << megabytes << " MB";
    document.undo(progress);
    ASSERT_EQ(shown_.state.positions.copy(), untouched) << megabytes << " MB";
    document.redo(progress);
    ASSERT_EQ(shown_.state.positions.copy(), pulled) << megabytes << " MB";
  }
  EXPECT_TRUE(is_opened);
  EXPECT_GT(refused, 5);
  EXPECT_EQ(shown_.opened, 3U);
  EXPECT_GT(shown_.state.positions.copy().size(), 90'000U);
}

// A session keeps its parameters as long as its document is open.
TEST_F(DocumentOpenTest, SessionKeepsItsParameters) {
  const std::string text =
      R"({"knead": 1, "parameters": {"length": 0.25}})"
      "\n"
      R"({"tool": "implicit", "path": [[0, 0, 1], [0, "$length", 1.2]], "inner": 0.1, "outer": 0.5})"
      "\n";
  fs::create_directories(folder_);
  write_file_atomically(folder_ / "first.knead", text);
  Document document(options());
  Progress progress;
  document.open_made(ShapeKind::sphere, 642, progress);
  document.open_session(folder_ / "first.knead", progress);
  document.set_live({pull()}, progress);
  document.finish(progress);
  document.save(folder_ / "saved.knead");
  ASSERT_EQ(errors_, "");
  const Session saved = read_session(folder_ / "saved.knead");
  EXPECT_EQ(saved.parameters, (std::vector<Parameter>{{"length", 0.25}}));
  ASSERT_EQ(saved.strokes.size(), 2U);
  EXPECT_EQ(std::get<ImplicitStroke>(with_values(saved, {{"length", 0.5}}).strokes[0].stroke).path[1],
            (Vec3d{0, 0.5, 1.2}));
  document.open_made(ShapeKind::sphere, 642, progress);
  document.set_live({pull()}, progress);
  document.finish(progress);
  document.save(folder_ / "other.knead");
  EXPECT_TRUE(read_session(folder_ / "other.knead").parameters.empty());
}

}  // namespace

namespace {

SessionStroke implicit(double inner, double outer) {
  ImplicitStroke stroke;
  stroke.path = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  stroke.inner = inner;
  stroke.outer = outer;
  return {stroke};
}

SessionStroke bend(double angle) {
  BendStroke stroke;
  stroke.angle_deg = angle;
  stroke.extent = BendWidth{0.5};
  return {stroke};
}

TEST(StrokeFields, EachNumberIsNamedOnceWithTheFirstValue) {
  const std::vector<SessionStroke> strokes{implicit(0.1, 0.4), implicit(0.2, 0.6)};
  const auto fields = fields_of(strokes);
  ASSERT_EQ(fields.size(), 3U);
  EXPECT_EQ(fields[2].name, "taper");
  EXPECT_EQ(fields[2].value, 0);
  EXPECT_EQ(fields[0].name, "inner");
  EXPECT_EQ(fields[0].value, 0.1);
  EXPECT_EQ(fields[1].name, "outer");
  EXPECT_EQ(fields[1].value, 0.4);
}

// The radius of a brush has one name, in the bar above and in the history; a reach that follows from it is not shown.
TEST(StrokeFields, ABrushHasTheRadiusThatItsSliderShows) {
  for (const char* brush : {"move", "crease"}) {
    std::vector<SessionStroke> strokes{{stroke_of(brush_named(brush), 0.25, 0.5)}};
    std::vector<StrokeField> fields = fields_of(strokes);
    EXPECT_EQ(fields.front().label, "radius") << brush;
    EXPECT_EQ(fields.front().value, 0.25) << brush;
    *find_value<double>(strokes.front().stroke, "outer") = 2;
    fields = fields_of(strokes);
    EXPECT_EQ(fields.front().label, "reach") << brush;
    EXPECT_EQ(fields.front().value, 2) << brush;
  }
}

TEST(StrokeFields, MirrorImagesKeepTheirSigns) {
  std::vector<SessionStroke> strokes{bend(30), bend(-30)};
  set_field(strokes, "angle_deg", 45);
  EXPECT_EQ(std::get<BendStroke>(strokes[0].stroke).angle_deg, 45);
  EXPECT_EQ(std::get<BendStroke>(strokes[1].stroke).angle_deg, -45);
  set_field(strokes, "width", 0.25);
  EXPECT_EQ(std::get<BendWidth>(std::get<BendStroke>(strokes[1].stroke).extent).width, 0.25);
  const std::vector<SessionStroke> before = strokes;
  set_field(strokes, "depth", 7);
  EXPECT_EQ(strokes, before);
}

TEST(StrokeFields, AllStrokesOfAnEntryHaveOneFalloff) {
  std::vector<SessionStroke> strokes{{MaskStroke{}}, implicit(0.1, 0.4), bend(30)};
  EXPECT_EQ(falloff_of(strokes), 4);
  set_falloff(strokes, 6);
  EXPECT_EQ(falloff_of(strokes), 6);
  EXPECT_EQ(std::get<ImplicitStroke>(strokes[1].stroke).falloff, 6);
  EXPECT_EQ(std::get<BendStroke>(strokes[2].stroke).falloff, 6);
  EXPECT_EQ(falloff_of(std::span(strokes).first(1)), std::nullopt);
}

}  // namespace

}  // namespace knead::studio::document_test
