#include "base/log.h"

int main(void)
{
    pel_info("DMN-001", "pelagosd %s", PEL_VERSION);
    return 0;
}
