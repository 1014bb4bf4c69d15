// Read by include_table_test.sh --self-test only, never compiled.
#include "flow/kernels/kernel.h"  // wrong
#include "knead/knead.h"
