/* Sentences by a subject that is a fit or a retrieval. */
#ifndef FF_WORDS_STRUCT_H
#define FF_WORDS_STRUCT_H
#include "ff_diagnosis.h"
#include "ff_words.h"
#include "fit/ndf/ndf_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Longest text of a sentence, its end included: of 16 parameters in channels with the longest names, and of the longest note. */
enum { FF_WORDS_SENTENCE = 2560 };

/** What a warning is about: a fit or a retrieved distribution, one of them NULL, and the problem whose channels it counts. */
typedef struct ff_words_subject {
    const ff_problem *problem;
    const ff_fit_result *fit;
    const ff_ndf_result *retrieved;
} ff_words_subject;

/** A warning of s as a sentence without a full stop: "kd (12 of 121 channels, 400nm to 500nm) is on its lower bound, 0". Returns
 *  out. */
const char *ff_words_warning(const ff_words_subject *s, const ff_warning *w, char out[FF_WORDS_SENTENCE]);

/** The k-th note of t with what its hint says behind it, into out; NULL when there are not so many. Returns out. */
const char *ff_words_note(const ff_table *t, size_t k, char out[FF_WORDS_SENTENCE]);

/** Where samples lie, "on the side of the light", and what of the command line mends it where they should not; "" for one that
 * needs nothing. */
const char *ff_words_side(ff_side side);
const char *ff_words_side_hint(ff_side side);

/** What was found of a file's angles or values, with the flag that mends it. Returns out. */
const char *ff_words_finding(const ff_finding *finding, char out[FF_WORDS_SENTENCE]);
/** "turned", "elevation", ...: the kind for programs; NULL for none. */
const char *ff_words_finding_kind(int kind);

/** Name of a parameter of a fit: "alpha_x". */
const char *ff_words_parameter(const ff_fit_result *fit, const ff_warning_parameter *p);

#ifdef __cplusplus
}
#endif
#endif
