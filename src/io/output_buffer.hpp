/* A C++ stream over ty_output, for libraries that write to one. It can be positioned; the output keeps write errors. */
#ifndef TY_IO_OUTPUT_BUFFER_HPP
#define TY_IO_OUTPUT_BUFFER_HPP

#include "io/file.h"

#include <algorithm>
#include <streambuf>

/* std::ostream stream(&buffer) writes to the output. */
class ty_output_buffer : public std::streambuf {
  public:
    explicit ty_output_buffer(ty_output* output) : output_(output) {
    }

  protected:
    std::streamsize xsputn(const char* bytes, std::streamsize size) override {
        if (!ty_output_write_at(output_, bytes, size_t(size), at_)) return 0;
        at_ += uint64_t(size);
        size_ = std::max(size_, at_);
        return size;
    }

    int_type overflow(int_type byte) override {
        if (traits_type::eq_int_type(byte, traits_type::eof())) return traits_type::not_eof(byte);
        const char one = traits_type::to_char_type(byte);
        return xsputn(&one, 1) == 1 ? byte : traits_type::eof();
    }

    pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
        const off_type base = from == std::ios_base::beg ? 0 : off_type(from == std::ios_base::cur ? at_ : size_);
        if (base + offset < 0) return pos_type(off_type(-1));
        at_ = uint64_t(base + offset);
        return pos_type(off_type(at_));
    }

    pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
        return seekoff(off_type(position), std::ios_base::beg, mode);
    }

  private:
    ty_output* output_;
    uint64_t at_ = 0;   /* offset of the next byte in the file */
    uint64_t size_ = 0; /* of the file so far */
};

#endif
