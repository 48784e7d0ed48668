/* FIPS 180-4, sections 4.1.2, 5.1.1 and 6.2. The constants are the first 32 bits of the fractional parts of square roots of the
 * first 8 primes, and of cube roots of the first 64. */
#include "internal_sha256.h"
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const uint32_t constant[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01,
    0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc,
    0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147,
    0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08,
    0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208,
    0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t turned(uint32_t x, int by)
{
    return x >> by | x << (32 - by);
}

/* One of the 64 steps, in which the eight words change places: their names do, and the words stay. */
static inline void take_step(uint32_t a, uint32_t b, uint32_t c, uint32_t *d, uint32_t e, uint32_t f, uint32_t g, uint32_t *h,
                             uint32_t w)
{
    const uint32_t one = *h + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) + (g ^ (e & (f ^ g))) + w;
    *d += one;
    *h = one + (turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) + ((a & b) | (c & (a | b)));
}

static void take_block(ff_sha256 *s)
{
    uint32_t w[64], v[8];
    for (int i = 0; i < 16; i++)
        w[i] = (uint32_t)s->block[4 * i] << 24 | (uint32_t)s->block[4 * i + 1] << 16 | (uint32_t)s->block[4 * i + 2] << 8 |
               s->block[4 * i + 3];
    for (int i = 16; i < 64; i++)
        w[i] = w[i - 16] + (turned(w[i - 15], 7) ^ turned(w[i - 15], 18) ^ w[i - 15] >> 3) + w[i - 7] +
               (turned(w[i - 2], 17) ^ turned(w[i - 2], 19) ^ w[i - 2] >> 10);
    memcpy(v, s->state, sizeof v);
    for (int i = 0; i < 64; i += 8) {
        take_step(v[0], v[1], v[2], &v[3], v[4], v[5], v[6], &v[7], constant[i] + w[i]);
        take_step(v[7], v[0], v[1], &v[2], v[3], v[4], v[5], &v[6], constant[i + 1] + w[i + 1]);
        take_step(v[6], v[7], v[0], &v[1], v[2], v[3], v[4], &v[5], constant[i + 2] + w[i + 2]);
        take_step(v[5], v[6], v[7], &v[0], v[1], v[2], v[3], &v[4], constant[i + 3] + w[i + 3]);
        take_step(v[4], v[5], v[6], &v[7], v[0], v[1], v[2], &v[3], constant[i + 4] + w[i + 4]);
        take_step(v[3], v[4], v[5], &v[6], v[7], v[0], v[1], &v[2], constant[i + 5] + w[i + 5]);
        take_step(v[2], v[3], v[4], &v[5], v[6], v[7], v[0], &v[1], constant[i + 6] + w[i + 6]);
        take_step(v[1], v[2], v[3], &v[4], v[5], v[6], v[7], &v[0], constant[i + 7] + w[i + 7]);
    }
    for (int i = 0; i < 8; i++) s->state[i] += v[i];
}

void ff_sha256_init(ff_sha256 *s)
{
    static const uint32_t first[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    memcpy(s->state, first, sizeof first);
    s->n = 0;
}

void ff_sha256_add(ff_sha256 *s, const void *bytes, size_t n)
{
    const unsigned char *from = bytes;
    while (n > 0) {
        const size_t at = s->n % 64, part = n < 64 - at ? n : 64 - at;
        memcpy(s->block + at, from, part);
        s->n += part;
        from += part;
        n -= part;
        if (s->n % 64 == 0) take_block(s);
    }
}

void ff_sha256_text(ff_sha256 *s, char out[FF_SHA256_TEXT])
{
    static const unsigned char padding[64] = {0x80};
    const uint64_t bits = 8 * s->n;
    unsigned char length[8];
    ff_sha256_add(s, padding, 1 + (119 - s->n % 64) % 64);
    for (int i = 0; i < 8; i++) length[i] = (unsigned char)(bits >> (56 - 8 * i));
    ff_sha256_add(s, length, 8);
    for (int i = 0; i < 8; i++) snprintf(out + 8 * i, 9, "%08x", (unsigned)s->state[i]);
}

int ff_sha256_file(const char *path, char out[FF_SHA256_TEXT])
{
    unsigned char bytes[8192];
    ff_sha256 s;
    struct stat st;
    if (!strcmp(path, "-") || stat(path, &st) != 0 || !S_ISREG(st.st_mode)) return 0;
    FILE *in = fopen(path, "rb");
    if (!in) return 0;
    ff_sha256_init(&s);
    for (size_t n; (n = fread(bytes, 1, sizeof bytes, in)) > 0;) ff_sha256_add(&s, bytes, n);
    const int failed = ferror(in);
    (void)fclose(in);
    if (failed) return 0;
    ff_sha256_text(&s, out);
    return 1;
}
