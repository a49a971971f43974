/* Lines, words and numbers of text mesh files. The text ends with a zero byte that is not counted. */
#ifndef TY_IO_MODEL_TEXT_H
#define TY_IO_MODEL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

/* The unread rest of a text or a line. */
typedef struct ty_words {
    const char* at;
    const char* end;
} ty_words;

typedef struct ty_word {
    const char* text; /* not zero-terminated */
    size_t length;
} ty_word;

/* Reads the next line, without its end; a backslash at the end joins it with the following line. *number is
 * increased by the lines read. False at the end of the text. */
bool ty_next_line(ty_words* text, ty_words* line, size_t* number);
/* Reads the next word; false if there is none. */
bool ty_next_word(ty_words* words, ty_word* word);
/* Reads the next word if it is a number. */
bool ty_next_number(ty_words* words, double* number);
/* The rest of the line, without blanks around it. */
ty_word ty_rest_of_line(ty_words* words);
bool ty_word_is(ty_word word, const char* text);

#endif
