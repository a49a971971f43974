/* Functions of the NetCDF library, which is loaded when the first file is opened: it brings a dozen other libraries,
 * which take more time to load than many commands run. */
#ifndef TY_IO_NETCDF_CALLS_H
#define TY_IO_NETCDF_CALLS_H

#include <netcdf.h>

struct ty_netcdf_calls {
    __typeof__(nc_open)* open;
    __typeof__(nc_close)* close;
    __typeof__(nc_strerror)* strerror;
    __typeof__(nc_inq_nvars)* inq_nvars;
    __typeof__(nc_inq_varid)* inq_varid;
    __typeof__(nc_inq_var)* inq_var;
    __typeof__(nc_inq_dim)* inq_dim;
    __typeof__(nc_inq_att)* inq_att;
    __typeof__(nc_get_att_text)* get_att_text;
    __typeof__(nc_get_att_string)* get_att_string;
    __typeof__(nc_free_string)* free_string;
    __typeof__(nc_get_att_double)* get_att_double;
    __typeof__(nc_get_vara_double)* get_vara_double;
};

#endif
