// Read by include_table_test.sh --self-test only, never compiled.
#include "knead/stroke.h"
#include "knead/editor/workbench.h"  // wrong
#include "session/inner.h"    // wrong
