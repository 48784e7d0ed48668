/* Every process adds its number and a share of a sum: all must know the totals. */
#include <mpi.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    int rank, size, total = -1;
    if (MPI_Init(&argc, &argv) != MPI_SUCCESS) return 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    const int mine = rank + 1;
    MPI_Allreduce(&mine, &total, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    const int right = size == 2 && total == 3;
    printf("process %d of %d: the sum is %d\n", rank, size, total);
    MPI_Finalize();
    return !right;
}
