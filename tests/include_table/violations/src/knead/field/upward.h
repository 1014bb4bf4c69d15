// Read by include_table_test.sh --self-test only, never compiled.
#pragma once

#include <vector>

#include <knead/session/session.h>  // wrong
#include "../math/box.h"            // wrong
#include "inner.h"
#include "knead/field/inner.h"
#include "knead/kitchen/sink.h"  // wrong
#include "knead/math/vec3.h"
#include "knead/mesh/mesh.h"  // wrong
#include "support/random.h"   // wrong
