// The filter's properties, its pipeline requests, and the fields of its output.
#include "vtkKnead.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTypes.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiProcessController.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkTimerLog.h>
#include <vtkTypeInt64Array.h>

#include <algorithm>
#include <optional>

#include "job.h"
#include "watched.h"

vtkStandardNewMacro(vtkKnead);

vtkKnead::vtkKnead() : Controller(vtkMultiProcessController::GetGlobalController()) {
  if (this->Controller != nullptr) this->Controller->Register(this);
}

vtkKnead::~vtkKnead() {
  if (this->Controller != nullptr) this->Controller->UnRegister(this);
}

void vtkKnead::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SessionFile: " << this->SessionFile << "\n"
     << indent << "RelativeTolerance: " << this->RelativeTolerance << "\n"
     << indent << "Diagonal: " << this->Diagonal << "\n"
     << indent << "Precision: " << this->Precision << "\n"
     << indent << "Inverse: " << this->Inverse << "\n"
     << indent << "Until: " << this->Until << "\n"
     << indent << "Quality: " << this->Quality << "\n"
     << indent << "FailOnInversion: " << this->FailOnInversion << "\n";
  for (const std::string& name : this->VectorsToTransform) os << indent << "VectorsToTransform: " << name << "\n";
}

void vtkKnead::SetSessionFile(const char* path) {
  const std::string text = path == nullptr ? "" : path;
  if (text == this->SessionFile) return;
  this->SessionFile = text;
  this->Modified();
}

void vtkKnead::AddVectorToTransform(const char* name) {
  if (name == nullptr || *name == '\0') return;
  this->VectorsToTransform.emplace_back(name);
  this->Modified();
}

void vtkKnead::ClearVectorsToTransform() {
  if (this->VectorsToTransform.empty()) return;
  this->VectorsToTransform.clear();
  this->Modified();
}

const double* vtkKnead::GetUntilRange() {
  this->UntilRange[1] = 1;
  try {
    const knead::Session session = knead::paraview::read_flow_session(this->SessionFile);
    this->UntilRange[1] = std::max(1.0, static_cast<double>(session.strokes.size()));
  } catch (const std::exception&) {
    // RequestData says what is wrong with the file.
  }
  return this->UntilRange;
}

int vtkKnead::FillInputPortInformation(int, vtkInformation* info) {
  // Else the pipeline would call RequestData for one block after the other.
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject");
  return 1;
}

int vtkKnead::RequestDataObject(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs) {
  vtkDataObject* const input = vtkDataObject::GetData(inputs[0]);
  if (input == nullptr) return 0;
  const int type = knead::paraview::output_type(*input);
  if (type < 0) {
    vtkErrorMacro("Knead takes no " << input->GetClassName() << "; it needs a data set with points");
    return 0;
  }
  const vtkDataObject* const output = vtkDataObject::GetData(outputs);
  if (output != nullptr && const_cast<vtkDataObject*>(output)->GetDataObjectType() == type) return 1;
  const auto fresh = vtkSmartPointer<vtkDataObject>::Take(vtkDataObjectTypes::NewDataObject(type));
  outputs->GetInformationObject(0)->Set(vtkDataObject::DATA_OBJECT(), fresh);
  return 1;
}

int vtkKnead::RequestData(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs) {
  using namespace knead::paraview;
  vtkDataObject* const input = vtkDataObject::GetData(inputs[0]);
  vtkDataObject* const output = vtkDataObject::GetData(outputs);
  std::optional<knead::Precision> precision;
  if (this->Precision < 2) precision = this->Precision == 0 ? knead::Precision::float32 : knead::Precision::float64;
  const Settings settings{this->SessionFile, this->RelativeTolerance, this->Diagonal,
                          precision,         this->Inverse,           this->Until,
                          this->Quality,     this->FailOnInversion,   this->VectorsToTransform};
  const Ranks ranks(this->Controller);
  const Watch watch = [&](knead::Progress& progress, const std::function<void()>& work) {
    run_watched(*this, progress, work);
  };
  try {
    std::vector<Block> blocks;
    ranks.together([&] {
      const vtkTimerLogScope timed("Knead: copy");
      blocks = copy_blocks(*input, *output);
    });
    const Findings findings = knead_blocks(blocks, settings, ranks, watch);
    for (const std::string& note : findings.notes) {
      if (ranks.rank() == 0) vtkWarningMacro(<< note);
    }
    vtkNew<vtkTypeInt64Array> inverted;
    inverted->SetName("KneadInvertedCells");
    inverted->InsertNextValue(findings.inverted);
    if (this->Quality) output->GetFieldData()->AddArray(inverted);
    return 1;
  } catch (const Failure& failure) {
    output->Initialize();
    const std::string what = failure.what();
    if (ranks.rank() == 0 && !what.empty()) vtkErrorMacro(<< what);
    return 0;
  }
}
