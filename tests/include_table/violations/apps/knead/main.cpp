// Read by include_table_test.sh --self-test only, never compiled.
#include "apps/knead/options.h"
#include "apps/studio/window.h"  // wrong
#include "bench/flow_bench.h"    // wrong
#include "knead/session.h"
#include "options.h"
#include "session/inner.h"  // wrong
