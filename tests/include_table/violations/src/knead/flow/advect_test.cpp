// Read by include_table_test.sh --self-test only, never compiled.
#include "knead/flow/advect.h"

#include "apps/knead/options.h"  // wrong
#include "knead/mesh/mesh.h"
#include "support/random.h"
