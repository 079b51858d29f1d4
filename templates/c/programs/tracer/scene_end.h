/* bladesmith: the end of what the tracer's headers define for one instance. */
#undef BS_ROW
#undef BS_FAR
#undef BS_FLOOR1
#undef BS_FACETS
