#include "link/datagram.hpp"
