// Read by include_table_test.sh --self-test only, never compiled.
#include "apps/studio/window.h"  // wrong
#include "json/json.h"           // wrong
#include "knead/session.h"
#include "session/inner.h"  // wrong
