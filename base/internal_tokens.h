/** @file internal_tokens.h  Words and numbers of free-form text: separated by blanks or commas, over as many lines as they take. */
#ifndef FF_INTERNAL_TOKENS_H
#define FF_INTERNAL_TOKENS_H
#include "internal_input.h"

/** Reader of tokens. Between calls `lines.line` is the line of the token handed out last. */
typedef struct ff_tokens {
    ff_lines lines;
    ff_error *err;
    char *at; /**< rest of the line, NULL = the next line is due */
} ff_tokens;

/** *t is written only on FF_OK; then ff_tokens_close must follow. */
ff_status ff_tokens_open(const char *path, ff_tokens *t, ff_error *err);
void ff_tokens_close(ff_tokens *t);

/** The next line without its blanks at the front, skipping blank ones and comments ('#' first); what was left of the line before is
 *  dropped. *text is NULL at the end. It may be changed; tokens then come from it. */
ff_status ff_tokens_line(ff_tokens *t, char **text);

/** The next word, '\0'-terminated; NULL at the end of the file. '#' at the start of a word ends the line. */
ff_status ff_tokens_word(ff_tokens *t, char **word);

/** Looks for another word: *end is 1 when there is none in the rest of the file. */
ff_status ff_tokens_at_end(ff_tokens *t, int *end);

/** The next n numbers into out. FF_ERR_READ at the end of the file, FF_ERR_DATA for a word that is no finite number; `what` is for
 *  the message ("a row of 31 values"). */
ff_status ff_tokens_numbers(ff_tokens *t, double *out, size_t n, const char *what);

/** The numbers of one line, separated by blanks or commas, up to `most` of them, into out; *n is their count. FF_ERR_FORMAT when
 *  there are more, FF_ERR_DATA for what is no finite number; path, line and `what` are for the message. A '#' ends the line. */
ff_status ff_line_numbers(const char *text, double *out, size_t most, size_t *n, const char *path, long line, const char *what,
                          ff_error *err);

/** A whole number >= 0 of at most `most` written with digits alone: 1, else 0. */
int ff_whole_number(const char *word, uint64_t most, uint64_t *out);
#endif
