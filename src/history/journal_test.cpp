// Journals: batches, recovery, saved and abandoned work.
#include "knead/editor/workbench.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/stroke.h"
#include "support/journal_work.h"
#include "support/outcome.h"
#include "support/test_meshes.h"

namespace knead::journal_test {
namespace {

namespace fs = std::filesystem;
using test::RandomWork;
using test::Scratch;
using test::short_stroke;
using test::without_lines;

class JournalTest : public testing::Test {
 protected:
  Journal create(const std::string& title = "new sphere") {
    return Journal::create(scratch_.path(), test::sphere(), title);
  }
  static std::vector<SessionStroke> recovered(const fs::path& folder) {
    return without_lines(recover_journal(folder).session.strokes);
  }
  static void write(const fs::path& path, std::string_view text) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
  }

  Scratch scratch_{"journal"};
};

TEST_F(JournalTest, EveryPrefixIsTheWorkUpToItsLastWholeBatch) {
  Journal journal = create();
  const fs::path path = journal.folder() / "session.knead";
  RandomWork work(7);
  std::vector<std::size_t> lengths{fs::file_size(path)};
  std::vector<std::vector<SessionStroke>> states{{}};
  for (int i = 0; i < 60; ++i) {
    work.step(&journal);
    lengths.push_back(fs::file_size(path));
    states.push_back(work.strokes());
    EXPECT_EQ(recovered(journal.folder()), work.strokes()) << i;
  }
  const std::string text = file_bytes(path);
  EXPECT_TRUE(whole_batches(text.substr(0, lengths[0] - 1)).empty());
  std::size_t state = 0;
  for (std::size_t length = lengths[0]; length <= text.size(); ++length) {
    while (state + 1 < lengths.size() && lengths[state + 1] <= length) ++state;
    const std::string_view whole = whole_batches(std::string_view(text).substr(0, length));
    ASSERT_EQ(whole.size(), lengths[state]) << length;
    if (lengths[state] != length) continue;
    EXPECT_EQ(without_lines(parse_session(whole, "cut").strokes), states[state]) << length;
  }
  EXPECT_EQ(state, 60U);
}

TEST_F(JournalTest, ACutFileIsRecoveredAndGoneOnIn) {
  Journal journal = create();
  const fs::path folder = journal.folder();
  const std::vector<SessionStroke> first{short_stroke(1, RemeshSettings{}), short_stroke(2)};
  journal.append(first);
  const std::vector<SessionStroke> second{short_stroke(3), short_stroke(4, test::edges_below(0.25)), short_stroke(5)};
  journal.replace(1, second);
  { const Journal gone = std::move(journal); }  // lets the lock go
  const std::string text = file_bytes(folder / "session.knead");
  std::size_t recoveries = 0;
  for (std::size_t lost = 1; whole_batches(text.substr(0, text.size() - lost)).size() > 200; lost += 17, ++recoveries) {
    write(folder / "session.knead", text.substr(0, text.size() - lost));
    EXPECT_EQ(recovered(folder), first);
    Journal again = Journal::attach(folder);
    again.append(second);
    std::vector<SessionStroke> all = first;
    all.insert(all.end(), second.begin(), second.end());
    EXPECT_EQ(recovered(folder), all);
  }
  EXPECT_GT(recoveries, 10U);
}

TEST_F(JournalTest, OtherReadersSeeAnOrdinarySession) {
  Journal journal = create();
  journal.append(std::vector<SessionStroke>{short_stroke(1), short_stroke(2), short_stroke(3, test::edges_below(0.5))});
  journal.replace(2, std::vector<SessionStroke>{short_stroke(4)});
  journal.undo(1);
  const Session session = read_session(journal.folder() / "session.knead");
  EXPECT_EQ(without_lines(session.strokes), std::vector<SessionStroke>{short_stroke(1)});
  EXPECT_TRUE(session.warnings.empty());
  EXPECT_EQ(session.mesh, "shape.ply");
  EXPECT_EQ(session.note, "new sphere");
}

TEST_F(JournalTest, TheShapeIsKeptByteForByteAndAComputedOneToTheBit) {
  ShapeFile read = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0.1\n# mine\nf 1 2 3\n", "obj", "mine.obj");
  const Journal kept = Journal::create(scratch_.path(), read, "mine.obj");
  EXPECT_EQ(recover_journal(kept.folder()).shape.bytes, read.bytes);
  EXPECT_EQ(recover_journal(kept.folder()).title, "mine.obj");
  const Journal computed = create();
  EXPECT_EQ(test::bits(recover_journal(computed.folder()).shape.mesh.positions),
            test::bits(test::sphere().mesh.positions));
  EXPECT_NE(kept.folder(), computed.folder());
}

TEST_F(JournalTest, WhatASessionFileHoldsIsSavedUntilSomethingIsWritten) {
  const fs::path file = scratch_.path() / "my work.knead";
  write(file, "{}");
  fs::path folder;
  const auto is_saved = [&] { return abandoned_journals(scratch_.path() / "journals").at(0).is_saved; };
  {
    Journal journal = Journal::create(scratch_.path() / "journals", test::sphere(), "new sphere");
    folder = journal.folder();
    journal.append(std::vector<SessionStroke>{short_stroke(1)});
  }
  EXPECT_FALSE(is_saved());
  Journal::attach(folder).note_saved(file);
  EXPECT_TRUE(is_saved());
  {
    Journal journal = Journal::attach(folder);
    journal.append(std::vector<SessionStroke>{short_stroke(2)});
  }
  EXPECT_FALSE(is_saved()) << "another stroke";
  Journal::attach(folder).note_saved(file);
  EXPECT_TRUE(is_saved());
  fs::remove(file);
  EXPECT_FALSE(is_saved()) << "the file is gone";
}

TEST_F(JournalTest, OnlyWhatNobodyHoldsIsAbandoned) {
  fs::path older;
  fs::path newer;
  {
    Journal journal = create("older");
    older = journal.folder();
    journal.append(std::vector<SessionStroke>{short_stroke(1), short_stroke(2)});
    Journal other = create("newer");
    newer = other.folder();
    EXPECT_TRUE(abandoned_journals(scratch_.path()).empty());
    EXPECT_THROW(Journal::attach(older), InvalidInput);
    discard_journal(older);
    EXPECT_TRUE(fs::exists(older));
  }
  const timespec long_ago[2] = {{1'000'000'000, 0}, {1'000'000'000, 0}};
  ::utimensat(AT_FDCWD, (older / "session.knead").c_str(), long_ago, 0);
  const std::vector<AbandonedJournal> journals = abandoned_journals(scratch_.path());
  ASSERT_EQ(journals.size(), 2U);
  EXPECT_EQ(journals[0].folder, newer);
  EXPECT_EQ(journals[0].strokes, 0U);
  EXPECT_EQ(journals[1].title, "older");
  EXPECT_EQ(journals[1].strokes, 2U);
  EXPECT_EQ(journals[1].problem, "");
  EXPECT_EQ(std::chrono::system_clock::to_time_t(journals[1].changed), 1'000'000'000);
  discard_journal(older);
  EXPECT_FALSE(fs::exists(older));
}

TEST_F(JournalTest, ABrokenOneSaysWhatIsWrong) {
  const fs::path folder = [&] { return create().folder(); }();
  write(folder / "session.knead", "{\"knead\": 1, \"mesh\": \"shape.ply\"}\n{\"tool\": \"hammer\"}\n");
  const std::vector<AbandonedJournal> journals = abandoned_journals(scratch_.path());
  ASSERT_EQ(journals.size(), 1U);
  EXPECT_NE(journals[0].problem.find("hammer"), std::string::npos) << journals[0].problem;
  EXPECT_THROW(recover_journal(folder), InvalidInput);
  write(folder / "session.knead", "{\"knead\": 1");
  EXPECT_THROW(Journal::attach(folder), InvalidInput);
  EXPECT_THROW(recover_journal(scratch_.path() / "nothing"), IoError);
  EXPECT_TRUE(abandoned_journals(scratch_.path() / "nothing").empty());
}

TEST_F(JournalTest, DiscardingRemovesTheFolder) {
  Journal journal = create();
  journal.append(std::vector<SessionStroke>{short_stroke(1)});
  journal.sync();
  journal.discard();
  EXPECT_FALSE(fs::exists(journal.folder()));
}

TEST_F(JournalTest, MoreThanThereIsCannotBeTakenBack) {
  Journal journal = create();
  journal.append(std::vector<SessionStroke>{short_stroke(1)});
  EXPECT_THROW(journal.undo(2), InvalidInput);
  journal.undo(1);
  EXPECT_TRUE(recovered(journal.folder()).empty());
}

TEST_F(JournalTest, TheRecoveredWorkIsTheShapeOnTheScreen) {
  Journal journal = create();
  RandomWork work(3);
  for (int i = 0; i < 12; ++i) work.step(&journal);
  Session screen;
  screen.strokes = work.strokes();
  for (SessionStroke& stroke : screen.strokes) stroke.remesh.reset();
  std::vector<Vec3d> expected = test::sphere().mesh.positions;
  for (const SessionStroke& stroke : screen.strokes) advect(flow_of(stroke.stroke), expected, {.tolerance = 1e-5});
  RecoveredWork back = recover_journal(journal.folder());
  std::vector<Vec3d> positions = back.shape.mesh.positions;
  for (const SessionStroke& stroke : back.session.strokes)
    advect(flow_of(stroke.stroke), positions, {.tolerance = 1e-5});
  EXPECT_EQ(test::bits(positions), test::bits(expected));
}

}  // namespace
}  // namespace knead::journal_test
