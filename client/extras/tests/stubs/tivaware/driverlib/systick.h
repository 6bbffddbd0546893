#include <driverlib/driverlib.h>
