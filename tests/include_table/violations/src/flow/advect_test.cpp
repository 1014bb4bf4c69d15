// Read by include_table_test.sh --self-test only, never compiled.
#include "apps/knead/options.h"  // wrong
#include "knead/flow.h"
#include "mesh/edges.h"
#include "support/random.h"
