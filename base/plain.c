/* Files as readers want them. Gzip by zlib (RFC 1950 to 1952); UTF-16 as Excel's "Unicode text" and PowerShell write it. */
#define _GNU_SOURCE
#include "internal_plain.h"
#include "internal_errno.h"
#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#define ZLIB_CONST
#include <zlib.h>

enum { BLOCK = 1 << 13, LOOKED_AT = 512 };

typedef struct plain {
    const char *path;
    ff_error *err;
    int from, to;
    int64_t written;
} plain;

static ff_status no_memory(const plain *p)
{
    return ff_error_set(p->err, FF_ERR_MEMORY, p->path, 0, -1, "no memory for what is unpacked");
}

/* Up to n bytes; fewer only at the end of the file. */
static ff_status take(const plain *p, int64_t at, void *out, size_t n, size_t *got)
{
    for (*got = 0; *got < n;) {
        const ssize_t r = read(p->from, (char *)out + *got, n - *got);
        if (r < 0 && errno == EINTR) continue;
        if (r < 0)
            return ff_error_set(p->err, FF_ERR_READ, p->path, 0, at + (int64_t)*got, "cannot be read further: %s",
                                ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
        if (r == 0) break;
        *got += (size_t)r;
    }
    return FF_OK;
}

static ff_status put(plain *p, const void *bytes, size_t n)
{
    if (p->written + (int64_t)n > (int64_t)1 << FF_PLAIN_BYTES_LOG2)
        return ff_error_set(p->err, FF_ERR_FORMAT, p->path, 0, -1,
                            "found more than %d GiB packed in it, expected less: unpack it to a file",
                            1 << (FF_PLAIN_BYTES_LOG2 - 30));
    for (size_t done = 0; done < n;) {
        const ssize_t w = write(p->to, (const char *)bytes + done, n - done);
        if (w < 0 && errno == EINTR) continue;
        if (w <= 0) return no_memory(p);
        done += (size_t)w;
    }
    p->written += (int64_t)n;
    return FF_OK;
}

/* ---- gzip ------------------------------------------------------------------------------------ */

static ff_status damaged(const plain *p, int64_t at, const char *what)
{
    return ff_error_set(p->err, FF_ERR_FORMAT, p->path, 0, at, "packed with gzip: found %s, expected more of it", what);
}

/* All of one block of packed bytes; *ended: a member of the file is complete. */
static ff_status inflate_block(plain *p, z_stream *z, int64_t at, int *ended)
{
    unsigned char out[BLOCK];
    while (z->avail_in > 0 || z->avail_out == 0) {
        if (*ended) {
            if (inflateReset(z) != Z_OK) return no_memory(p);
            *ended = 0;
        }
        z->next_out = out;
        z->avail_out = sizeof out;
        const int code = inflate(z, Z_NO_FLUSH);
        if (code == Z_MEM_ERROR) return no_memory(p);
        if (code == Z_BUF_ERROR) break; /* nothing to do before more arrives */
        if (code != Z_OK && code != Z_STREAM_END) return damaged(p, at, z->msg ? z->msg : "bytes that are none of it");
        const ff_status status = put(p, out, sizeof out - z->avail_out);
        if (status != FF_OK) return status;
        *ended = code == Z_STREAM_END;
        if (*ended && z->avail_in == 0) break;
    }
    return FF_OK;
}

static ff_status inflate_all(plain *p, z_stream *z)
{
    unsigned char in[BLOCK];
    int ended = 0;
    for (int64_t at = 0;; at += (int64_t)sizeof in) {
        size_t got = 0;
        ff_status status = take(p, at, in, sizeof in, &got);
        if (status != FF_OK) return status;
        if (got == 0) return ended ? FF_OK : damaged(p, at, "the end of the file");
        z->next_in = in;
        z->avail_in = (uInt)got;
        z->avail_out = 1;
        status = inflate_block(p, z, at, &ended);
        if (status != FF_OK) return status;
    }
}

static ff_status unpack(plain *p)
{
    z_stream z;
    memset(&z, 0, sizeof z);
    if (inflateInit2(&z, 16 + MAX_WBITS) != Z_OK) return no_memory(p);
    const ff_status status = inflate_all(p, &z);
    inflateEnd(&z);
    return status;
}

/* ---- UTF-16 ---------------------------------------------------------------------------------- */

static size_t put_utf8(uint32_t c, char *out)
{
    if (c < 0x80) {
        out[0] = (char)c;
        return 1;
    }
    const size_t n = c < 0x800 ? 2 : c < 0x10000 ? 3 : 4;
    for (size_t k = n; k-- > 1; c >>= 6) out[k] = (char)(0x80 | (c & 0x3F));
    out[0] = (char)((n == 2 ? 0xC0 : n == 3 ? 0xE0 : 0xF0) | c);
    return n;
}

static uint32_t unit_at(const unsigned char *p, int big)
{
    return big ? (uint32_t)p[0] << 8 | p[1] : (uint32_t)p[1] << 8 | p[0];
}

/* -1: no UTF-16; else 0 little and 1 big end first. Text is all but control characters, and mostly of ASCII. */
static int utf16_order(const unsigned char *head, size_t n)
{
    if (n < 4) return -1;
    const int marked = (head[0] == 0xFF && head[1] == 0xFE) || (head[0] == 0xFE && head[1] == 0xFF);
    size_t ascii = 0, units = 0, zero[2] = {0, 0};
    for (size_t k = 0; k + 1 < n; k++) zero[k & 1] += head[k] == 0;
    const int big = marked ? head[0] == 0xFE : zero[0] > zero[1];
    if (!marked && zero[big ? 0 : 1] * 5 < n) return -1;         /* the upper halves of ASCII */
    if (unit_at(head + (marked ? 2 : 0), big) == '<') return -1; /* what reads XML knows it */
    for (size_t k = marked ? 2 : 0; k + 1 < n; k += 2, units++) {
        const uint32_t u = unit_at(head + k, big);
        if (u < 0x20 && u != '\t' && u != '\n' && u != '\r') return -1;
        ascii += u < 0x7F;
    }
    return units && 10 * ascii >= 9 * units ? big : -1;
}

static ff_status convert(plain *p, int big)
{
    unsigned char in[BLOCK];
    char out[2 * BLOCK];
    uint32_t high = 0;
    for (int64_t at = 0;; at += (int64_t)sizeof in) {
        size_t got = 0, used = 0;
        ff_status status = take(p, at, in, sizeof in, &got);
        if (status != FF_OK) return status;
        for (size_t k = 0; k + 1 < got; k += 2) {
            const uint32_t u = unit_at(in + k, big);
            const int low = (u & 0xFC00) == 0xDC00;
            if (high && !low) used += put_utf8(0xFFFD, out + used);
            if ((u & 0xFC00) == 0xD800) {
                high = u;
                continue;
            }
            if (at + (int64_t)k > 0 || u != 0xFEFF)
                used += put_utf8(low && high ? 0x10000 + ((high & 0x3FF) << 10) + (u & 0x3FF) : low ? 0xFFFD : u, out + used);
            high = 0;
        }
        status = put(p, out, used);
        if (status != FF_OK || got < sizeof in) return status;
    }
}

/* ---- opening --------------------------------------------------------------------------------- */

ff_status ff_plain_open(const char *path, int *fd, int64_t *size, ff_error *err)
{
    unsigned char head[LOOKED_AT];
    const off_t start = *size > 1 ? lseek(*fd, 0, SEEK_CUR) : -1;
    const ssize_t n = start < 0 ? 0 : pread(*fd, head, sizeof head, start);
    const int packed = n > 2 && head[0] == 0x1F && head[1] == 0x8B && head[2] == 8;
    const int order = n > 3 && !packed ? utf16_order(head, (size_t)n) : -1;
    if (!packed && order < 0) return FF_OK;
    plain p = {path, err, *fd, memfd_create("facetfit-plain", MFD_CLOEXEC), 0};
    ff_status status = p.to < 0 ? no_memory(&p) : packed ? unpack(&p) : convert(&p, order);
    if (status == FF_OK && lseek(p.to, 0, SEEK_SET) != 0) status = no_memory(&p);
    if (strcmp(path, "-") == 0) lseek(*fd, start, SEEK_SET); /* the place is that of standard input itself */
    close(*fd);
    if (status != FF_OK) {
        if (p.to >= 0) close(p.to);
        return status;
    }
    *fd = p.to;
    *size = p.written;
    return packed ? ff_plain_open(path, fd, size, err) : FF_OK; /* text in UTF-16 may have been packed */
}

/* ---- characters ------------------------------------------------------------------------------ */

size_t ff_plain_latin(unsigned char c, char *out)
{
    static const unsigned short windows[32] = {0x20AC, 0xFFFD, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                               0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0xFFFD, 0x017D, 0xFFFD,
                                               0xFFFD, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                               0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0xFFFD, 0x017E, 0x0178};
    return put_utf8(c >= 0x80 && c < 0xA0 ? windows[c - 0x80] : c, out);
}

int ff_plain_is_utf8(const char *text, size_t length)
{
    for (size_t k = 0; k < length;) {
        const unsigned char c = (unsigned char)text[k];
        const size_t n = c < 0x80 ? 1 : c >= 0xC2 && c < 0xE0 ? 2 : (c & 0xF0) == 0xE0 ? 3 : c >= 0xF0 && c < 0xF5 ? 4 : 0;
        if (n == 0 || k + n > length) return 0;
        for (size_t j = 1; j < n; j++)
            if (((unsigned char)text[k + j] & 0xC0) != 0x80) return 0;
        k += n;
    }
    return 1;
}
