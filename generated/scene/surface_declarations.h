BS_SURFACE void FN(prepare_evolved_circles_1)(const S *parameters, S *row);
BS_SURFACE void FN(normal_evolved_circles_1)(S normal[BS_LENGTH(3)], const S *row, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)]);
BS_SURFACE void FN(hits_evolved_circles_1_isolate)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_circles_1_companion)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_circles_1_sampled)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(prepare_evolved_circles_2)(const S *parameters, S *row);
BS_SURFACE void FN(normal_evolved_circles_2)(S normal[BS_LENGTH(3)], const S *row, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)]);
BS_SURFACE void FN(hits_evolved_circles_2_isolate)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_circles_2_companion)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_circles_2_sampled)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(prepare_evolved_circles_3)(const S *parameters, S *row);
BS_SURFACE void FN(normal_evolved_circles_3)(S normal[BS_LENGTH(3)], const S *row, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)]);
BS_SURFACE void FN(hits_evolved_circles_3_isolate)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_circles_3_companion)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_circles_3_sampled)(const S *row, const S ray[BS_LENGTH(6)], S search[BS_LENGTH(4)],
    S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(prepare_evolved_point_pairs_1)(const S *parameters, S *row);
BS_SURFACE void FN(normal_evolved_point_pairs_1)(S normal[BS_LENGTH(3)], const S *row, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)]);
BS_SURFACE void FN(hits_evolved_point_pairs_1_isolate)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_point_pairs_1_companion)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_point_pairs_1_sampled)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(prepare_evolved_point_pairs_2)(const S *parameters, S *row);
BS_SURFACE void FN(normal_evolved_point_pairs_2)(S normal[BS_LENGTH(3)], const S *row, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)]);
BS_SURFACE void FN(hits_evolved_point_pairs_2_isolate)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_point_pairs_2_companion)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_point_pairs_2_sampled)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(prepare_evolved_point_pairs_3)(const S *parameters, S *row);
BS_SURFACE void FN(normal_evolved_point_pairs_3)(S normal[BS_LENGTH(3)], const S *row, const S ray[BS_LENGTH(6)],
    const S hit[BS_LENGTH(9)]);
BS_SURFACE void FN(hits_evolved_point_pairs_3_isolate)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_point_pairs_3_companion)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
BS_SURFACE void FN(hits_evolved_point_pairs_3_sampled)(const S *row, const S ray[BS_LENGTH(6)],
    S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers);
