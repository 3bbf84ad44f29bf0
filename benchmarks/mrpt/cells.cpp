// Reads a map of map_server with MRPT and prints what its cells are: cells MAP.yaml
// The first line is "resolution x y", the lower left corner; then a line for each row from the lowest y upwards, with #
// for an occupied cell, a blank for a free one and ? for an unknown one.
#include <mrpt/maps/COccupancyGridMap2D.h>

#include <iostream>

int main(int, char** arguments) {
  mrpt::maps::COccupancyGridMap2D map;
  if (!map.loadFromROSMapServerYAML(arguments[1])) {
    return 1;
  }
  std::cout << map.getResolution() << " " << map.getXMin() << " " << map.getYMin() << "\n";
  for (unsigned row = 0; row < map.getSizeY(); ++row) {
    for (unsigned column = 0; column < map.getSizeX(); ++column) {
      // MRPT keeps the probability that a cell is free.
      const float free = map.getCell(column, row);
      std::cout << (free < 0.3f ? '#' : free > 0.7f ? ' ' : '?');
    }
    std::cout << "\n";
  }
}
