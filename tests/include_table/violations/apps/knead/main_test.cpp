// Read by include_table_test.sh --self-test only, never compiled.
#include "apps/studio/window.h"  // wrong
#include "session/inner.h"
