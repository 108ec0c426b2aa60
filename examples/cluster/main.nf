// A map in N shards, and a table of all that it came to:
//
//   nextflow run main.nf --shards 100 --map "/data/dsm.tif --uavs /data/sites.csv --radius 2000 -o '/data/out/{site}.tif'"
//
// Paths are absolute, as each task has a folder of its own. What a shard had done before it was killed is left alone.
params.shards = 100
params.map = ""

process shard {
    errorStrategy 'retry'
    maxRetries 3
    cpus 1

    input:
    val k

    output:
    val k

    script:
    "skyshed map ${params.map} --resume --quiet --threads ${task.cpus} --shard ${k}/${params.shards}"
}

process merge {
    publishDir '.'

    input:
    val done

    output:
    path 'merged.csv'

    script:
    "skyshed jobs merge -o merged.csv map ${params.map}"
}

workflow {
    channel.of(1..(params.shards as int)) | shard | collect | merge
}
