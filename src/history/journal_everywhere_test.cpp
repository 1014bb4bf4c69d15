// What a journal does on every system; journal_test.cpp has more, with what only POSIX has.
#include <gtest/gtest.h>

#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "support/journal_work.h"

namespace knead::journal_everywhere_test {
namespace {

namespace fs = std::filesystem;

TEST(JournalEverywhere, IsMadeContinuedRecoveredAndRemoved) {
  const test::Scratch scratch("everywhere");
  fs::path folder;
  std::vector<SessionStroke> all{test::short_stroke(1), test::short_stroke(2)};
  {
    Journal journal = Journal::create(scratch.path(), test::sphere(), "work");
    folder = journal.folder();
    journal.append(all);
    journal.sync();
    EXPECT_EQ(journal.trouble(), std::nullopt);
    EXPECT_TRUE(abandoned_journals(scratch.path()).empty()) << "it is in use";
    EXPECT_EQ(recover_journal(folder).session.strokes.size(), 2U) << "in use, it can be read";
    EXPECT_THROW(Journal::attach(folder), InvalidInput);
    discard_journal(folder);
    EXPECT_TRUE(fs::exists(folder / "session.knead")) << "in use, it stays";
  }
  ASSERT_EQ(abandoned_journals(scratch.path()).size(), 1U);
  EXPECT_EQ(abandoned_journals(scratch.path())[0].strokes, 2U);
  {
    Journal journal = Journal::attach(folder);
    journal.append(std::vector<SessionStroke>{test::short_stroke(3)});
  }
  EXPECT_EQ(recover_journal(folder).session.strokes.size(), 3U);
  discard_journal(folder);
  EXPECT_FALSE(fs::exists(folder));
}

TEST(JournalEverywhere, IsDiscardedWhileItIsOpen) {
  const test::Scratch scratch("everywhere_open");
  {
    Journal journal = Journal::create(scratch.path(), test::sphere(), "work");
    journal.discard();
  }
  EXPECT_TRUE(fs::is_empty(scratch.path()));
}

}  // namespace
}  // namespace knead::journal_everywhere_test
