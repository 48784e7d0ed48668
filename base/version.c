/* The version that was built. */
#include "ff_version.h"

const char *ff_version(void)
{
    return FF_VERSION_STRING;
}

int ff_version_number(void)
{
    return FF_VERSION_NUMBER;
}
