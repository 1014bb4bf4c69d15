// Read by include_table_test.sh --self-test only, never compiled.
#include "knead/editor/workbench.h"  // wrong
#include "knead/stroke.h"
#include "session/inner.h"  // wrong
