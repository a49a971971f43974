/* The decoder of one precision, TY_JPEG_DECODER, from the library whose jpeglib.h was included before. Samples are
 * those of the bit stream: DICOM's monochrome frames have no colour transform. */
#include "base/context.h"

#include <setjmp.h>

/* A decoder, where it jumps to from its errors, and its message. */
typedef struct jpeg_job {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_source_mgr source;
    jmp_buf failed;
    char message[JMSG_LENGTH_MAX];
} jpeg_job;

static void fail_job(j_common_ptr jpeg) {
    jpeg_job* job = jpeg->client_data;
    if (job->message[0] == '\0') jpeg->err->format_message(jpeg, job->message);
    longjmp(job->failed, 1);
}

/* Some warnings tell of damaged data, for which the library makes up pixels. */
static void take_warning(j_common_ptr jpeg, int level) {
    const int code = jpeg->err->msg_code;
    if (level < 0 &&
        (code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE || code == JWRN_JPEG_EOF || code == JWRN_MUST_RESYNC))
        fail_job(jpeg);
}

static void ignore_text(j_common_ptr jpeg) {
    (void)jpeg;
}

static void ignore_source(j_decompress_ptr jpeg) {
    (void)jpeg;
}

static boolean refuse_more(j_decompress_ptr jpeg) {
    jpeg_job* job = jpeg->client_data;
    snprintf(job->message, sizeof job->message, "it is cut short");
    fail_job((j_common_ptr)jpeg);
    return FALSE;
}

static void skip_source(j_decompress_ptr jpeg, long count) {
    if (count <= 0) return;
    if ((size_t)count > jpeg->src->bytes_in_buffer) refuse_more(jpeg);
    jpeg->src->next_input_byte += count;
    jpeg->src->bytes_in_buffer -= (size_t)count;
}

static void open_job(jpeg_job* job, const ty_dicom_packed* frame) {
    job->jpeg.err = jpeg_std_error(&job->errors);
    job->errors.error_exit = fail_job;
    job->errors.emit_message = take_warning;
    job->errors.output_message = ignore_text;
    job->jpeg.client_data = job;
    job->source = (struct jpeg_source_mgr){.next_input_byte = frame->bytes,
                                           .bytes_in_buffer = frame->size,
                                           .init_source = ignore_source,
                                           .fill_input_buffer = refuse_more,
                                           .skip_input_data = skip_source,
                                           .resync_to_restart = jpeg_resync_to_restart,
                                           .term_source = ignore_source};
}

/* Rows of the frame into `out`; row has room for one. */
static void read_rows(jpeg_job* job, const ty_dicom_packed* frame, JSAMPLE* row, uint8_t* out) {
    const size_t columns = (size_t)frame->columns;
    for (int32_t j = 0; j < frame->rows; ++j) {
        JSAMPROW rows[1] = {row};
        if (jpeg_read_scanlines(&job->jpeg, rows, 1) != 1) refuse_more(&job->jpeg);
        for (size_t i = 0; i < columns; ++i) {
            const uint16_t sample = (uint16_t)row[i];
            const size_t at = columns * (size_t)j + i;
            if (frame->sample_size == 1)
                out[at] = (uint8_t)sample;
            else
                ((uint16_t*)(void*)out)[at] = sample;
        }
    }
}

ty_result TY_JPEG_DECODER(const ty_dicom_packed* frame, uint8_t* out) {
    ty_context* context = frame->context;
    jpeg_job* job = ty_alloc_array(context, 1, sizeof *job, true);
    JSAMPLE* row = ty_alloc_array(context, (size_t)frame->columns, sizeof *row, false);
    ty_result result = job == NULL || row == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) {
        open_job(job, frame);
        if (setjmp(job->failed) == 0) {
            jpeg_create_decompress(&job->jpeg);
            job->jpeg.src = &job->source;
            jpeg_read_header(&job->jpeg, TRUE);
            if (job->jpeg.image_width != (JDIMENSION)frame->columns ||
                job->jpeg.image_height != (JDIMENSION)frame->rows || job->jpeg.num_components != 1 ||
                job->jpeg.data_precision > (int)(8 * frame->sample_size)) {
                ty_dicom_wrong_frame(frame, job->jpeg.image_width, job->jpeg.image_height, job->jpeg.num_components,
                                     job->jpeg.data_precision);
                longjmp(job->failed, 1);
            }
            job->jpeg.out_color_space = job->jpeg.jpeg_color_space;
            jpeg_start_decompress(&job->jpeg);
            read_rows(job, frame, row, out);
        } else {
            result = TY_ERROR_INPUT;
        }
        if (result != TY_OK && !ty_has_error(context))
            ty_fail(context, result, "%s: cannot decode this JPEG frame: %s", frame->path, job->message);
        jpeg_destroy_decompress(&job->jpeg);
    }
    if (job != NULL) ty_free_array(context, job, 1, sizeof *job);
    if (row != NULL) ty_free_array(context, row, (size_t)frame->columns, sizeof *row);
    return result;
}
