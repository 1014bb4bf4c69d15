// Read by include_table_test.sh --self-test only, never compiled.
#pragma once

#include <vector>

#include <knead/session.h>  // wrong
#include "../math/box.h"    // wrong
#include "field/inner.h"
#include "inner.h"         // wrong
#include "kitchen/sink.h"  // wrong
#include "knead/mesh.h"    // wrong
#include "knead/vec.h"
#include "mesh/edges.h"      // wrong
#include "support/random.h"  // wrong
