// Read by include_table_test.sh --self-test only, never compiled.
#include "apps/knead/options.h"
#include "apps/studio/window.h"   // wrong
#include "bench/flow_bench.h"     // wrong
#include "knead/session/inner.h"  // wrong
#include "knead/session/session.h"
#include "options.h"
