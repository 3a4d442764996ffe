extends Node3D
## A hundred volumes of two scans, turned, stretched and overlapping, on a spiral.

## How many.
@export_range(1, 400) var count := 100
## Draws the turns and sizes.
@export var seed_value := 7

const LOOKS: PackedStringArray = ["ct-muscle", "ct-skin", "ct-bone", "ct-angiography"]
const GOLDEN_ANGLE := 2.399963

@onready var _source: PhantomSource = $PhantomSource
@onready var _crowd: Node3D = $Crowd


func _ready() -> void:
	var random := RandomNumberGenerator.new()
	random.seed = seed_value
	var volumes: Array[LumivoxVolume3D] = []
	for i in count:
		var node := LumivoxVolume3D.new()
		var radius := 0.15 * sqrt(i + 0.5)
		var angle := i * GOLDEN_ANGLE
		node.position = Vector3(radius * cos(angle), 0.13 + 0.10 * sin(radius * 5.0), radius * sin(angle))
		node.rotation = Vector3(random.randf_range(-0.35, 0.35), random.randf_range(-PI, PI), random.randf_range(-0.35, 0.35))
		node.scale = Vector3.ONE * random.randf_range(0.55, 1.0)
		node.scale.y *= random.randf_range(0.8, 1.25)
		_crowd.add_child(node)
		volumes.append(node)
	_source.targets = volumes
	_source.preset = ""
	_source.grown.connect(_on_grown.bind(volumes))


## Few transfer functions for many volumes: a resource may be shared.
func _on_grown(_volume: LumivoxVolume, volumes: Array[LumivoxVolume3D]) -> void:
	for i in volumes.size():
		var look := LOOKS[i % LOOKS.size()]
		volumes[i].apply_preset(look)
