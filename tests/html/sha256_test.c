/* SHA-256 against the published vectors (FIPS 180-4's examples), in pieces of every size, and of a file. */
#include "base/internal_sha256.h"
#include "ff_test.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct {
    const char *text, *digest;
} known[] = {{"", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
             {"abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
             {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
             {"abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu",
              "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1"}};

static void vectors(void)
{
    char got[FF_SHA256_TEXT];
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        for (size_t piece = 1; piece < 70; piece++) {
            ff_sha256 s;
            ff_sha256_init(&s);
            const size_t n = strlen(known[k].text);
            for (size_t at = 0; at < n; at += piece) ff_sha256_add(&s, known[k].text + at, n - at < piece ? n - at : piece);
            ff_sha256_text(&s, got);
            FF_CHECK(!strcmp(got, known[k].digest), "'%s' in pieces of %zu: %s", known[k].text, piece, got);
        }
}

static void million(void)
{
    char got[FF_SHA256_TEXT], a[1000];
    ff_sha256 s;
    ff_sha256_init(&s);
    memset(a, 'a', sizeof a);
    for (int k = 0; k < 1000; k++) ff_sha256_add(&s, a, sizeof a);
    ff_sha256_text(&s, got);
    FF_CHECK(!strcmp(got, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"), "a million a: %s", got);
}

static void files(void)
{
    char got[FF_SHA256_TEXT], name[] = "/tmp/facetfit-sha256-XXXXXX";
    const int fd = mkstemp(name);
    if (!FF_CHECK(fd >= 0, "no temporary file")) return;
    FF_CHECK(write(fd, "abc", 3) == 3, "cannot write %s", name);
    close(fd);
    FF_CHECK(ff_sha256_file(name, got) && !strcmp(got, known[1].digest), "of a file: %s", got);
    unlink(name);
    FF_CHECK(!ff_sha256_file(name, got) && !ff_sha256_file("-", got) && !ff_sha256_file("/tmp", got), "of what is no file");
}

FF_TEST_MAIN(FF_TEST(vectors), FF_TEST(million), FF_TEST(files))
