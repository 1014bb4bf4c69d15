// The version of the library whose headers these are, MAJOR.MINOR.PATCH; each number is at most 99.
#pragma once

// For messages.
#define KNEAD_VERSION "0.10.0"

// For `#if`: 10000 MAJOR + 100 MINOR + PATCH.
#define KNEAD_VERSION_NUMBER 1000
