/* Prints proto/nmea.md: the text of standard input, then the table of the
 * sentences that are read. */
#include <stdio.h>

int main(void)
{
    static const struct {
        const char *address, *text;
    } sentences[] = {
#define NMEA_SENTENCE(kind, address, parse, take, text) { address, text },
#include "bridges/nmea_sentences.def"
#undef NMEA_SENTENCE
    };
    for (int c; (c = getchar()) != EOF;) {
        putchar(c);
    }
    printf("| sentence | |\n|---|---|\n");
    for (size_t i = 0; i < sizeof sentences / sizeof sentences[0]; i++) {
        printf("| %s | %s |\n", sentences[i].address, sentences[i].text);
    }
    return 0;
}
