/* The code of the terms. In it $T is the type of numbers, $F what stands before a function, and $min, $max, $abs, $erf are those of
 * the language. */
#ifndef FF_INTERNAL_SNIPPET_TERMS_H
#define FF_INTERNAL_SNIPPET_TERMS_H

/* What a term has by its name; NULL: no code. */
typedef struct ff_snippet_term {
    const char *name;
    const char *code; /* functions; "" where the call says all                                        */
    const char *call; /* what stands for it in the sum                                                */
    int needs_lambda; /* of a masking: the distribution has to have lambda                            */
} ff_snippet_term;

/* Of a distribution code has $F NAME_p(q2) and NAME_lambda(v). */
const ff_snippet_term *ff_snippet_ndf(const char *name);
const ff_snippet_term *ff_snippet_masking(const char *name);
const ff_snippet_term *ff_snippet_fresnel(const char *name);
const ff_snippet_term *ff_snippet_base(const char *name);
/* "a, b, c" of a kind: 0 distributions, 1 maskings, 2 Fresnel terms, 3 what stands under lobes. */
void ff_snippet_known(int kind, char *out, unsigned size);
#endif
