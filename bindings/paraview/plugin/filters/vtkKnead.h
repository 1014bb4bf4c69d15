// The filter Knead: moves the points of a data set along the flow of a session.
#ifndef vtkKnead_h
#define vtkKnead_h

#include <vtkDataObjectAlgorithm.h>

#include <string>
#include <vector>

#include "KneadFiltersModule.h"  // for the export macro

class vtkMultiProcessController;

// Takes polydata, unstructured and structured grids, images and rectilinear grids (which become structured grids), and
// multi-block or partitioned collections of these. On several ranks all must be updated together. docs/paraview.md
// explains the properties.
class KNEADFILTERS_EXPORT vtkKnead : public vtkDataObjectAlgorithm {
 public:
  static vtkKnead* New();
  vtkTypeMacro(vtkKnead, vtkDataObjectAlgorithm) void PrintSelf(ostream& os, vtkIndent indent) override;

  // The file with the strokes.
  void SetSessionFile(const char* path);
  const char* GetSessionFile() const { return this->SessionFile.c_str(); }

  // Position error of one path line over one segment, as a part of the diagonal.
  vtkSetMacro(RelativeTolerance, double);
  vtkGetMacro(RelativeTolerance, double);

  // What the tolerance refers to. 0: the diagonal of the box of all points on all ranks.
  vtkSetMacro(Diagonal, double);
  vtkGetMacro(Diagonal, double);

  // In which the fields are evaluated: 0 in float, 1 in double, 2 in double where there are cells with a volume.
  vtkSetClampMacro(Precision, int, 0, 2);
  vtkGetMacro(Precision, int);

  // Applies the session backwards.
  vtkSetMacro(Inverse, bool);
  vtkGetMacro(Inverse, bool);
  vtkBooleanMacro(Inverse, bool);

  // The number of strokes that are applied; 2.5 ends half way through the third. Beyond the last stroke: all.
  vtkSetMacro(Until, double);
  vtkGetMacro(Until, double);

  // Adds the arrays KneadVolumeRatio, KneadScaledJacobian, KneadNonOrthogonality, KneadSkewness and KneadStretch.
  vtkSetMacro(Quality, bool);
  vtkGetMacro(Quality, bool);
  vtkBooleanMacro(Quality, bool);

  // Refuses a session that inverts a cell.
  vtkSetMacro(FailOnInversion, bool);
  vtkGetMacro(FailOnInversion, bool);
  vtkBooleanMacro(FailOnInversion, bool);

  // The names of vectors at the points that are carried by the Jacobian.
  void AddVectorToTransform(const char* name);
  void ClearVectorsToTransform();

  // The strokes of the session that are on, from 0; for the slider of Until.
  const double* GetUntilRange() VTK_SIZEHINT(2);

 protected:
  vtkKnead();
  ~vtkKnead() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override;

 private:
  vtkKnead(const vtkKnead&) = delete;
  void operator=(const vtkKnead&) = delete;

  std::string SessionFile;
  double RelativeTolerance = 1e-5;
  double Diagonal = 0;
  int Precision = 2;
  bool Inverse = false;
  double Until = 1e6;
  bool Quality = true;
  bool FailOnInversion = true;
  std::vector<std::string> VectorsToTransform;
  double UntilRange[2] = {0, 1};
  vtkMultiProcessController* Controller = nullptr;
};

#endif
