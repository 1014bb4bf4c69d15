#include "knead/fit/fit.h"

#include <gtest/gtest.h>
