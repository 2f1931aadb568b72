/* Writes proto/nmea.md: the text of the file given, and the table of the
 * sentences that are read. */
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    static const struct {
        const char *address, *text;
    } sentences[] = {
#define NMEA_SENTENCE(kind, address, parse, take, text) { address, text },
#include "bridges/nmea_sentences.def"
#undef NMEA_SENTENCE
    };
    FILE *text = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (!text) {
        fprintf(stderr, "usage: nmea_doc TEXT\n");
        return EXIT_FAILURE;
    }
    for (int c; (c = fgetc(text)) != EOF;) {
        putchar(c);
    }
    fclose(text);
    printf("| sentence | |\n|---|---|\n");
    for (size_t i = 0; i < sizeof sentences / sizeof sentences[0]; i++) {
        printf("| %s | %s |\n", sentences[i].address, sentences[i].text);
    }
    return EXIT_SUCCESS;
}
