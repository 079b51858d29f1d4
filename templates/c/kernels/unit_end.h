/* bladesmith: ends what unit.h began. */
#if BS_BYTES >= 32
BS_V3_END
#endif
#include "instance_end.h"
