/* bladesmith: begins a unit of kernels for one instance; unit_end.h ends it, so that another may follow.
 *
 * Defined before, here or by the compiler's options: BS_BITS (64 or 32), BS_BYTES (vector bytes), BS_TAG (the
 * instance's name). BS_SOURCE_HASH, a string, says what an installed unit was compiled from.
 */
#include "table.h"

#if BS_BYTES == 64
BS_V4_BEGIN
#elif BS_BYTES == 32
BS_V3_BEGIN
#endif
#include "instance.h"
#include "rows.h"
