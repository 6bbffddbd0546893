// Sketches for the established library include this file in addition to <ros.h>, which contains everything.
#include "ros.h"
