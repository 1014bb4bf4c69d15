// Read by include_table_test.sh --self-test only, never compiled.
#include "knead/session/inner.h"  // wrong
#include "knead/session/session.h"
