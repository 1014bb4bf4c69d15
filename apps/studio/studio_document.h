// The open document for the window's thread. The worker's thread does the work on the Document.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "document/document.h"
#include "platform/worker.h"
#include "preferences.h"

namespace knead::studio {

struct StudioOptions {
  std::filesystem::path config = config_folder();
  std::filesystem::path state = state_folder();
  bool has_worker = true;
  int threads = 0;  // of the deformation; 0: all
};

class StudioDocument {
 public:
  using Job = std::function<void(Document&, Progress&)>;

  // Calls `after_post` after each job is posted; without a worker's thread the job is done by then.
  StudioDocument(const StudioOptions& options, std::function<void()> after_post);
  ~StudioDocument() { end_work(); }
  StudioDocument(const StudioDocument&) = delete;
  StudioDocument& operator=(const StudioDocument&) = delete;

  // Returns the document as of the last refresh().
  const DocumentState& shown() const { return shown_; }
  // Takes over the results of the worker. Returns true if another document was opened.
  bool refresh();

  // Posts a job to the worker, which does jobs in order; `what` names it for people. For post_latest see Worker.
  void post(const Job& job, std::string what = {});
  std::uint64_t post_latest(const Job& job, std::string what = {}, bool gives_way = false);
  // For jobs: makes the next refresh() call `result`, on the window's thread.
  void deliver(std::function<void()> result);
  Worker& worker() { return *worker_; }
  const Worker& worker() const { return *worker_; }

  // Messages for the user, from any thread. A notice without an error withdraws the errors about its subject.
  void tell(Notice notice);
  void withdraw(Subject subject) { tell({false, {}, subject}); }
  std::vector<Notice> take_notices();

  // Files. `open` takes a session (.knead) or a shape.
  void open(const std::filesystem::path& path);
  void open_made(ShapeKind kind, std::size_t vertices);
  // Adds a shape to those that are open.
  void add(const std::filesystem::path& path);
  // Shows or hides an object; makes one the active one.
  void show_object(std::size_t object, bool is_visible);
  void make_active(std::optional<std::size_t> object);
  // Removes one of several objects.
  void remove(std::size_t object);
  void save(const std::filesystem::path& path);
  void export_shape(const std::filesystem::path& path, bool as_double = false);
  void export_frames(const std::filesystem::path& file, const FrameExport& how);
  // The files that were opened last. note_opened() puts the open one in front and writes the list.
  const std::vector<std::filesystem::path>& recent() const { return recent_; }
  void note_opened();

  // Unsaved work of an earlier run, and what to do with it.
  const std::vector<AbandonedJournal>& abandoned() const { return abandoned_; }
  void recover(std::filesystem::path journal);
  void discard(std::filesystem::path journal);

  // Closes the document and removes its journal. Otherwise the next start offers to recover it.
  void close();

  // Completes the posted jobs and ends the worker's thread. Post nothing afterwards. If jobs use other objects than the
  // document, call this before those are destroyed.
  void end_work() { worker_.reset(); }

  // Counts the crossings of the shape in the background; shown() then has their number.
  void count_crossings();

 private:
  DocumentOptions document_options(const StudioOptions& options);
  Worker::Job on_document(const Job& job);

  std::filesystem::path state_folder_;
  std::function<void()> after_post_;
  std::vector<std::filesystem::path> recent_;
  std::vector<AbandonedJournal> abandoned_;
  DocumentState shown_;

  // Between the threads.
  struct Mailbox {
    std::mutex mutex;
    DocumentState shown;
    std::vector<Notice> notices;
    std::set<Subject> troubled;  // of errors that were told and not withdrawn
    std::vector<std::function<void()>> results;
  };
  Mailbox mailbox_;
  Document document_;             // the worker's
  std::optional<Worker> worker_;  // ends before what its jobs use
};

}  // namespace knead::studio
