// Sketches for the established library include this beside <ros.h>, which has all of it.
#include "ros.h"
