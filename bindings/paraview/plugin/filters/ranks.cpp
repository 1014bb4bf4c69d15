// Exchanges numbers and messages through ParaView's controller.
#include "ranks.h"

#include <vtkCommunicator.h>
#include <vtkDoubleArray.h>
#include <vtkMultiProcessController.h>
#include <vtkNew.h>
#include <vtkTimerLog.h>

#include <array>
#include <exception>

#include "knead/error.h"

namespace knead::paraview {

namespace {
constexpr const char* kExchange = "Knead: exchange";
}  // namespace

int Ranks::rank() const { return controller_ == nullptr ? 0 : controller_->GetLocalProcessId(); }

int Ranks::count() const { return controller_ == nullptr ? 1 : controller_->GetNumberOfProcesses(); }

int Ranks::least(int number) const {
  int result = number;
  if (count() == 1) return result;
  const vtkTimerLogScope timed(kExchange);
  controller_->AllReduce(&number, &result, 1, vtkCommunicator::MIN_OP);
  return result;
}

std::string Ranks::sent_from(int rank, std::string text) const {
  if (count() == 1) return text;
  const vtkTimerLogScope timed(kExchange);
  auto size = static_cast<int>(text.size());
  controller_->Broadcast(&size, 1, rank);
  text.resize(static_cast<std::size_t>(size));
  if (size > 0) controller_->Broadcast(text.data(), size, rank);
  return text;
}

std::string Ranks::first(const std::string& text) const {
  const int from = least(text.empty() ? count() : rank());
  return from == count() ? std::string() : sent_from(from, text);
}

void Ranks::together(const std::function<void()>& work) const {
  std::string message;
  bool has_failed = true;
  try {
    work();
    has_failed = false;
  } catch (const Cancelled&) {
    message.clear();
  } catch (const std::bad_alloc&) {
    message = "out of memory; use more machines";
  } catch (const std::exception& error) {
    message = error.what();
  }
  const int from = least(has_failed ? rank() : count());
  if (from != count()) throw Failure(sent_from(from, message));
}

std::int64_t Ranks::sum(std::int64_t number) const {
  long long own = number;
  long long result = own;
  if (count() == 1) return result;
  const vtkTimerLogScope timed(kExchange);
  controller_->AllReduce(&own, &result, 1, vtkCommunicator::SUM_OP);
  return result;
}

Box Ranks::united(const Box& box) const {
  if (count() == 1) return box;
  const vtkTimerLogScope timed(kExchange);
  const std::array<double, 6> own{box.min.x, box.min.y, box.min.z, -box.max.x, -box.max.y, -box.max.z};
  std::array<double, 6> all{};
  controller_->AllReduce(own.data(), all.data(), own.size(), vtkCommunicator::MIN_OP);
  return {{all[0], all[1], all[2]}, {-all[3], -all[4], -all[5]}};
}

std::vector<double> Ranks::gathered(std::vector<double> own) const {
  if (count() == 1) return own;
  const vtkTimerLogScope timed(kExchange);
  vtkNew<vtkDoubleArray> sent;
  vtkNew<vtkDoubleArray> received;
  sent->SetArray(own.data(), static_cast<vtkIdType>(own.size()), 1);
  controller_->AllGatherV(sent, received);
  return {received->GetPointer(0), received->GetPointer(0) + received->GetNumberOfValues()};
}

}  // namespace knead::paraview
