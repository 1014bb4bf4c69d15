// The document's state for the window's thread, and jobs for the worker's.
#include "studio_document.h"

#include <algorithm>
#include <utility>

#include "knead/error.h"

namespace knead::studio {

namespace {

std::filesystem::path journals_of(const StudioOptions& options) { return options.state / "journals"; }

}  // namespace

DocumentOptions StudioDocument::document_options(const StudioOptions& options) {
  DocumentOptions result;
  result.journals = journals_of(options);
  result.threads = options.threads;
  result.show = [this](const DocumentState& shown) {
    const std::lock_guard lock(mailbox_.mutex);
    mailbox_.shown = shown;
  };
  result.tell = [this](Notice notice) { tell(std::move(notice)); };
  result.name_work = [this](std::string what) { worker_->name(std::move(what)); };
  return result;
}

StudioDocument::StudioDocument(const StudioOptions& options, std::function<void()> after_post)
    : state_folder_(options.state), after_post_(std::move(after_post)), document_(document_options(options)) {
  worker_.emplace(options.has_worker, [this](Progress& progress) { document_.when_idle(progress); });
  recent_ = load_recent(state_folder_);
  abandoned_ = abandoned_journals(journals_of(options));
}

bool StudioDocument::refresh() {
  const std::uint64_t opened = shown_.opened;
  std::vector<std::function<void()>> results;
  {
    const std::lock_guard lock(mailbox_.mutex);
    if (mailbox_.shown.version != shown_.version) shown_ = mailbox_.shown;
    results = std::exchange(mailbox_.results, {});
  }
  for (const std::function<void()>& result : results) result();
  return shown_.opened != opened;
}

Worker::Job StudioDocument::on_document(const Job& job) {
  return [this, job](Progress& progress) { job(document_, progress); };
}

void StudioDocument::post(const Job& job, std::string what) {
  worker_->post(on_document(job), std::move(what));
  after_post_();
}

std::uint64_t StudioDocument::post_latest(const Job& job, std::string what, bool gives_way) {
  const std::uint64_t number = worker_->post_latest(on_document(job), std::move(what), gives_way);
  after_post_();
  return number;
}

void StudioDocument::deliver(std::function<void()> result) {
  const std::lock_guard lock(mailbox_.mutex);
  mailbox_.results.push_back(std::move(result));
}

void StudioDocument::tell(Notice notice) {
  const std::lock_guard lock(mailbox_.mutex);
  const bool withdraws = !notice.is_error && mailbox_.troubled.erase(notice.subject) > 0;
  if (notice.text.empty() && !withdraws) return;
  if (notice.is_error && notice.subject != Subject::other) mailbox_.troubled.insert(notice.subject);
  mailbox_.notices.push_back(std::move(notice));
}

std::vector<Notice> StudioDocument::take_notices() {
  const std::lock_guard lock(mailbox_.mutex);
  return std::exchange(mailbox_.notices, {});
}

void StudioDocument::open(const std::filesystem::path& path) {
  if (path.extension() == ".knead") {
    post([path](Document& document, Progress& progress) { document.open_session(path, progress); },
         "Opening the session");
  } else {
    post([path](Document& document, Progress& progress) { document.open_shape(path, progress); }, "Opening the shape");
  }
}

void StudioDocument::open_made(ShapeKind kind, std::size_t vertices) {
  post([kind, vertices](Document& document, Progress& progress) { document.open_made(kind, vertices, progress); },
       "Making the shape");
}

void StudioDocument::add(const std::filesystem::path& path) {
  post([path](Document& document, Progress& progress) { document.add_shape(path, progress); }, "Adding the shape");
}

void StudioDocument::show_object(std::size_t object, bool is_visible) {
  post([object, is_visible](Document& document, Progress& /*progress*/) { document.show_object(object, is_visible); });
}

void StudioDocument::make_active(std::optional<std::size_t> object) {
  post([object](Document& document, Progress& /*progress*/) { document.make_active(object); });
}

void StudioDocument::remove(std::size_t object) {
  post([object](Document& document, Progress& progress) { document.remove_object(object, progress); },
       "Removing the shape");
}

void StudioDocument::save(const std::filesystem::path& path) {
  post([path](Document& document, Progress& /*progress*/) { document.save(path); }, "Saving");
}

void StudioDocument::export_shape(const std::filesystem::path& path, bool as_double) {
  post([path, as_double](Document& document, Progress& progress) { document.export_shape(path, as_double, progress); },
       "Exporting");
}

void StudioDocument::export_frames(const std::filesystem::path& file, const FrameExport& how) {
  post([file, how](Document& document, Progress& progress) { document.export_frames(file, how, progress); },
       "Exporting frames");
}

void StudioDocument::note_opened() {
  if (shown_.shape_path.empty()) return;
  add_recent(recent_, std::filesystem::absolute(shown_.shape_path));
  try {
    save_recent(state_folder_, recent_);
  } catch (const IoError& error) {
    tell({true, error.what()});
  }
}

// The path may be one of those that are erased.
void StudioDocument::recover(std::filesystem::path journal) {
  std::erase_if(abandoned_, [&](const AbandonedJournal& one) { return one.folder == journal; });
  post([journal](Document& document, Progress& progress) { document.recover(journal, progress); }, "Recovering");
}

void StudioDocument::discard(std::filesystem::path journal) {
  std::erase_if(abandoned_, [&](const AbandonedJournal& one) { return one.folder == journal; });
  discard_journal(journal);
}

void StudioDocument::count_crossings() {
  post([](Document& document, Progress& progress) { document.count_crossings(progress); }, "Counting crossings");
}

void StudioDocument::close() {
  post([](Document& document, Progress& /*progress*/) { document.close(); });
  worker_->wait();
}

}  // namespace knead::studio
