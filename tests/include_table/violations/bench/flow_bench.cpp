// Read by include_table_test.sh --self-test only, never compiled.
#include "apps/studio/window.h"
#include "flow/advect_kernel.h"  // wrong
#include "knead/knead.h"
