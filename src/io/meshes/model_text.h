/* Lines, words and numbers of mesh files that are text. The text ends with a zero that does not count. */
#ifndef TY_IO_MODEL_TEXT_H
#define TY_IO_MODEL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

/* What is left of a text or a line. */
typedef struct ty_words {
    const char* at;
    const char* end;
} ty_words;

typedef struct ty_word {
    const char* text; /* not ended by a zero */
    size_t length;
} ty_word;

/* Takes the next line, without its end; a backslash before the end of a line joins it with the one after. *number is
 * raised by the lines taken. False at the end of the text. */
bool ty_next_line(ty_words* text, ty_words* line, size_t* number);
/* Takes the next word, false when there is none. */
bool ty_next_word(ty_words* words, ty_word* word);
/* Takes the next word when it is a number. */
bool ty_next_number(ty_words* words, double* number);
/* All that is left of the line, without blanks around it. */
ty_word ty_rest_of_line(ty_words* words);
bool ty_word_is(ty_word word, const char* text);

#endif
