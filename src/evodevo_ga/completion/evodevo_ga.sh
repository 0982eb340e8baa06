# What can stand after `ros2 run evodevo_ga`; made by scripts/completion.py.
_evodevo_words_evodevo_ga() {
    case "$1 $2" in
        " ") echo "descent evolve report status" ;;
        "descent ") echo "--help --number --out -o" ;;
        "descent -") echo "<files>" ;;
        "descent --number") echo "<any>" ;;
        "descent --out") echo "<files>" ;;
        "descent -o") echo "<files>" ;;
        "evolve ") echo "--age-gap --cells --crossover --deletion --duplication --elite --evaluations --extent --flip --founders --generations --give-up-after --help --hours --layers --look --niches --out --patience --point-decades --point-mutation --point-scale --population --preset --quiet --resume --run-length --scent-extent --scent-mutation --scheme --seed --set --simulators --start --start-share --starts --task --threads --tournament --units --view --world" ;;
        "evolve --age-gap") echo "<any>" ;;
        "evolve --cells") echo "<any>" ;;
        "evolve --crossover") echo "<any>" ;;
        "evolve --deletion") echo "<any>" ;;
        "evolve --duplication") echo "<any>" ;;
        "evolve --elite") echo "<any>" ;;
        "evolve --evaluations") echo "<any>" ;;
        "evolve --extent") echo "<any>" ;;
        "evolve --flip") echo "<any>" ;;
        "evolve --founders") echo "<any>" ;;
        "evolve --generations") echo "<any>" ;;
        "evolve --give-up-after") echo "<any>" ;;
        "evolve --hours") echo "<any>" ;;
        "evolve --layers") echo "<any>" ;;
        "evolve --look") echo "<any>" ;;
        "evolve --niches") echo "<any>" ;;
        "evolve --out") echo "<files>" ;;
        "evolve --patience") echo "<any>" ;;
        "evolve --point-decades") echo "<any>" ;;
        "evolve --point-mutation") echo "<any>" ;;
        "evolve --point-scale") echo "<any>" ;;
        "evolve --population") echo "<any>" ;;
        "evolve --preset") echo "low_drag high_drag" ;;
        "evolve --resume") echo "<files>" ;;
        "evolve --run-length") echo "<any>" ;;
        "evolve --scent-extent") echo "<any>" ;;
        "evolve --scent-mutation") echo "<any>" ;;
        "evolve --scheme") echo "<any>" ;;
        "evolve --seed") echo "<any>" ;;
        "evolve --set") echo "<any>" ;;
        "evolve --simulators") echo "<any>" ;;
        "evolve --start") echo "<files>" ;;
        "evolve --start-share") echo "<any>" ;;
        "evolve --starts") echo "<any>" ;;
        "evolve --task") echo "swim walk chemotaxis" ;;
        "evolve --threads") echo "<any>" ;;
        "evolve --tournament") echo "<any>" ;;
        "evolve --units") echo "<any>" ;;
        "evolve --view") echo "<files>" ;;
        "evolve --world") echo "flat slope steps rough obstacles gap <files>" ;;
        "report ") echo "--help --out --palette -o" ;;
        "report -") echo "<files>" ;;
        "report --out") echo "<files>" ;;
        "report --palette") echo "paper safe" ;;
        "report -o") echo "<files>" ;;
        "status ") echo "--help --look" ;;
        "status --look") echo "<any>" ;;
    esac
}
