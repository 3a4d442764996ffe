using System;
using NUnit.Framework;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace StandIn.Tests
{
    /// Compute kernels: what they do, and what an engine complains of.
    class KernelTests
    {
        const string Text = @"
#pragma kernel scale
#pragma kernel fill
#pragma kernel sample
cbuffer params_buffer { uint4 size; float4 factor; }
ByteAddressBuffer source;
RWByteAddressBuffer result;
RWTexture3D<unorm float> atlas;
Texture3D<float4> pool;
SamplerState sampler_linear_clamp;
float offset;
[numthreads(4, 1, 1)] void scale(uint3 id : SV_DispatchThreadID) { result.Store(id.x * 4, asuint(asfloat(source.Load(id.x * 4)) * factor.y + offset)); }
[numthreads(1, 1, 1)] void fill(uint3 id : SV_DispatchThreadID) { atlas[id] = (id.x + 4 * id.y + 16 * id.z) / 255.0; }
[numthreads(1, 1, 1)] void sample(uint3 id : SV_DispatchThreadID) { result.Store(0, asuint(pool.SampleLevel(sampler_linear_clamp, float3(.5, .5, .5), 0).x)); }";

        ComputeShader shader;
        GraphicsBuffer source, result, parameters;
        CommandBuffer commands;

        [SetUp]
        void Begin()
        {
            shader = ComputeShader.FromText("test", Text);
            source = new GraphicsBuffer(GraphicsBuffer.Target.Raw, 4, 4) { name = "source" };
            result = new GraphicsBuffer(GraphicsBuffer.Target.Raw | GraphicsBuffer.Target.CopySource, 4, 4) { name = "result" };
            parameters = new GraphicsBuffer(GraphicsBuffer.Target.Constant, 2, 16) { name = "parameters" };
            commands = new CommandBuffer { name = "test" };
            source.SetData(new[] { 1f, 2f, 3f, 4f });
        }

        [TearDown]
        void End()
        {
            source.Dispose();
            result.Dispose();
            parameters.Dispose();
            commands.Dispose();
        }

        void SetAll(float factor)
        {
            commands.SetBufferData(parameters, new[] { 4f, 0, 0, 0, 0, factor, 0, 0 });
            commands.SetComputeConstantBufferParam(shader, "params_buffer", parameters, 0, 32);
            commands.SetComputeBufferParam(shader, 0, "source", source);
            commands.SetComputeBufferParam(shader, 0, "result", result);
        }

        float[] Result() { var read = new float[4]; result.GetData(read); return read; }

        [Test]
        void Runs_in_the_order_of_the_commands()
        {
            SetAll(2);
            commands.DispatchCompute(shader, 0, 1, 1, 1);
            var seen = new float[2][];
            commands.RequestAsyncReadback(result, request => seen[0] = request.GetData<float>().ToArray());
            SetAll(3);
            commands.DispatchCompute(shader, 0, 1, 1, 1);
            commands.RequestAsyncReadback(result, 8, 8, request => seen[1] = request.GetData<float>().ToArray());
            var submissions = Gpu.submissions;
            Graphics.ExecuteCommandBuffer(commands);
            Assert.That(Gpu.submissions, Is.EqualTo(submissions + 1));
            for (int frame = 0; frame < ReadBacks.latency; frame++) { Engine.Frame(); Assert.That(seen[0], Is.Null); }
            Engine.Frame();
            Assert.That(seen[0], Is.EqualTo(new[] { 2f, 4, 6, 8 }));
            Assert.That(seen[1], Is.EqualTo(new[] { 9f, 12 }));
        }

        [Test]
        void Single_values_fill_their_constant_buffer()
        {
            SetAll(1);
            commands.SetComputeFloatParam(shader, "offset", 10);
            commands.DispatchCompute(shader, 0, 1, 1, 1);
            Graphics.ExecuteCommandBuffer(commands);
            Assert.That(Result(), Is.EqualTo(new[] { 11f, 12, 13, 14 }));
        }

        [Test]
        void A_property_that_is_not_set_skips_the_dispatch()
        {
            result.SetData(new[] { 7f, 7, 7, 7 });
            commands.SetComputeBufferParam(shader, 0, "source", source);
            commands.SetComputeBufferParam(shader, 0, "result", result);
            commands.DispatchCompute(shader, 0, 1, 1, 1);
            Log.Expect(LogType.Error, "kernel 'scale' (index 0): Property (params_buffer) is not set");
            Graphics.ExecuteCommandBuffer(commands);
            Assert.That(Result(), Is.EqualTo(new[] { 7f, 7, 7, 7 }));
        }

        [Test]
        void What_is_released_before_execution_is_seen()
        {
            SetAll(1);
            commands.DispatchCompute(shader, 0, 1, 1, 1);
            source.Release();
            Log.Expect(LogType.Error, "the GraphicsBuffer 'source' was released before the CommandBuffer was executed");
            Graphics.ExecuteCommandBuffer(commands);
        }

        [Test]
        void A_released_buffer_is_refused()
        {
            source.Release();
            Assert.Throws<NullReferenceException>(() => source.SetData(new[] { 1f }));
            Assert.Throws<NullReferenceException>(() => commands.SetComputeBufferParam(shader, 0, "source", source));
            Assert.That(source.IsValid(), Is.False);
        }

        [Test]
        void Buffers_are_bound_as_what_they_are()
        {
            using (var structured = new GraphicsBuffer(GraphicsBuffer.Target.Structured, 4, 4) { name = "other" })
            {
                SetAll(1);
                commands.SetComputeBufferParam(shader, 0, "source", structured);
                commands.DispatchCompute(shader, 0, 1, 1, 1);
                Log.Expect(LogType.Error, "Property (source) is a ByteAddressBuffer, but the GraphicsBuffer 'other' has no Target.Raw");
                Graphics.ExecuteCommandBuffer(commands);
                Assert.Throws<ArgumentException>(() => commands.SetComputeConstantBufferParam(shader, "params_buffer", structured, 0, 16));
                Assert.Throws<ArgumentException>(() => commands.SetComputeConstantBufferParam(shader, "params_buffer", parameters, 16, 16), "offsets are aligned");
                Assert.Throws<ArgumentException>(() => commands.CopyBuffer(source, result), "no CopySource");
                Assert.Throws<ArgumentException>(() => commands.CopyBuffer(result, source), "no CopyDestination");
            }
        }

        [Test]
        void A_constant_buffer_is_as_large_as_its_kernel_wants()
        {
            SetAll(1);
            commands.SetComputeConstantBufferParam(shader, "params_buffer", parameters, 0, 16);
            commands.DispatchCompute(shader, 0, 1, 1, 1);
            Log.Expect(LogType.Error, "Property (params_buffer) has 32 bytes, but 16 are set");
            Graphics.ExecuteCommandBuffer(commands);
        }

        [TestCase(0)]
        [TestCase(65536)]
        void Groups_are_more_than_none_and_not_too_many(int groups)
        {
            SetAll(1);
            commands.DispatchCompute(shader, 0, groups, 1, 1);
            Log.Expect(LogType.Error, "Thread group count");
            Graphics.ExecuteCommandBuffer(commands);
        }

        RenderTexture Volume(bool write, GraphicsFormat format)
        {
            var volume = new RenderTexture(new RenderTextureDescriptor(4, 4, format, 0) { dimension = TextureDimension.Tex3D, volumeDepth = 4, enableRandomWrite = write }) { name = "volume" };
            volume.Create();
            return volume;
        }

        [TestCase(GraphicsFormat.R8_UNorm)]
        [TestCase(GraphicsFormat.R16_UNorm)]
        [TestCase(GraphicsFormat.R16_SFloat)]
        void Writes_and_samples_volumes(GraphicsFormat format)
        {
            var volume = Volume(true, format);
            commands.SetComputeTextureParam(shader, 1, "atlas", volume);
            commands.DispatchCompute(shader, 1, 4, 4, 4);
            commands.SetComputeTextureParam(shader, 2, "pool", volume);
            commands.SetComputeBufferParam(shader, 2, "result", result);
            commands.DispatchCompute(shader, 2, 1, 1, 1);
            Graphics.ExecuteCommandBuffer(commands);
            Assert.That(Pictures.Read(volume, 2).At(1, 3).r, Is.EqualTo(45 / 255f).Within(1e-4));
            Assert.That(Result()[0], Is.EqualTo(31.5 / 255).Within(.6 / 255), "between the eight texels in the middle");
            volume.Release();
        }

        [Test]
        void What_is_written_was_created_for_it()
        {
            var volume = Volume(false, GraphicsFormat.R8_UNorm);
            commands.SetComputeTextureParam(shader, 1, "atlas", volume);
            commands.DispatchCompute(shader, 1, 4, 4, 4);
            Log.Expect(LogType.Error, "Property (atlas) is written, but the texture 'volume' was created without the UAV usage flag set");
            Graphics.ExecuteCommandBuffer(commands);
            UnityEngine.Object.DestroyImmediate(volume);
        }

        [Test]
        void A_texture_has_the_form_that_is_wanted()
        {
            var flat = new RenderTexture(new RenderTextureDescriptor(4, 4, GraphicsFormat.R8_UNorm, 0) { enableRandomWrite = true }) { name = "flat" };
            commands.SetComputeTextureParam(shader, 1, "atlas", flat);
            commands.DispatchCompute(shader, 1, 4, 4, 1);
            Log.Expect(LogType.Error, "Property (atlas) wants a texture that is solid, but 'flat' is flat");
            Graphics.ExecuteCommandBuffer(commands);
            flat.Release();
        }

        [Test]
        void A_texture_destroyed_before_execution_is_seen()
        {
            var volume = Volume(true, GraphicsFormat.R8_UNorm);
            commands.SetComputeTextureParam(shader, 1, "atlas", volume);
            commands.DispatchCompute(shader, 1, 4, 4, 4);
            UnityEngine.Object.DestroyImmediate(volume);
            Log.Expect(LogType.Error, "the texture 'volume' was destroyed before the CommandBuffer was executed");
            Graphics.ExecuteCommandBuffer(commands);
        }

        [Test]
        void Data_is_copied_when_it_is_recorded()
        {
            var data = new NativeArray<float>(new[] { 5f, 6, 7, 8 }, Allocator.Persistent);
            commands.SetBufferData(result, data);
            data[0] = 99;
            data.Dispose();
            Graphics.ExecuteCommandBuffer(commands);
            Assert.That(Result(), Is.EqualTo(new[] { 5f, 6, 7, 8 }));
            Assert.Throws<ObjectDisposedException>(() => commands.SetBufferData(result, data));
            Assert.Throws<ArgumentOutOfRangeException>(() => { using (var long5 = new NativeArray<float>(5, Allocator.Temp)) commands.SetBufferData(result, long5); });
        }

        [Test]
        void Recording_leaves_no_garbage()
        {
            using (var data = new NativeArray<float>(8, Allocator.Persistent))
            {
                int scale = shader.FindKernel("scale"), id = Shader.PropertyToID("source");
                long before = 0;
                for (int round = 0; round < 3; round++)
                {
                    commands.Clear();
                    if (round == 2) before = GC.GetAllocatedBytesForCurrentThread();
                    for (int i = 0; i < 200; i++)
                    {
                        commands.SetBufferData(parameters, data, 0, 0, 8);
                        commands.SetComputeBufferParam(shader, scale, id, source);
                        commands.DispatchCompute(shader, scale, 1, 1, 1);
                    }
                }
                Assert.That(GC.GetAllocatedBytesForCurrentThread() - before, Is.Zero);
            }
        }

        [Test]
        void A_kernel_that_does_not_compile_is_not_supported()
        {
            var broken = ComputeShader.FromText("broken", "#pragma kernel none\n[numthreads(1, 1, 1)] void none() { undeclared = 1; }");
            Log.Expect(LogType.Error, "Shader error");
            Assert.That(broken.IsSupported(0), Is.False);
            Assert.Throws<ArgumentException>(() => broken.FindKernel("other"));
        }
    }

    class BufferTests
    {
        [TestCase(GraphicsBuffer.Target.Raw, 0, 4)]
        [TestCase(GraphicsBuffer.Target.Raw, 4, 3)]
        [TestCase(GraphicsBuffer.Target.Raw, 4, 16)]
        [TestCase(GraphicsBuffer.Target.Structured, 4, 6)]
        [TestCase(GraphicsBuffer.Target.Constant, 3, 4)]
        [TestCase(GraphicsBuffer.Target.Constant, 5000, 16)]
        void Sizes_and_strides_are_checked(GraphicsBuffer.Target target, int count, int stride) =>
            Assert.Throws<ArgumentException>(() => new GraphicsBuffer(target, count, stride));

        [Test]
        void What_is_made_is_full_of_rubbish()
        {
            using (var buffer = new GraphicsBuffer(GraphicsBuffer.Target.Raw, 2, 4))
            {
                var read = new uint[2];
                buffer.GetData(read);
                Assert.That(read, Is.EqualTo(new[] { 0xcdcdcdcd, 0xcdcdcdcd }));
            }
        }

        [Test]
        void What_is_alive_is_counted()
        {
            int buffers = Live.buffers, textures = Live.renderTextures;
            var buffer = new GraphicsBuffer(GraphicsBuffer.Target.Raw, 4, 4);
            var texture = new RenderTexture(4, 4, 0);
            Assert.That(Live.renderTextures, Is.EqualTo(textures), "nothing is made before Create");
            texture.Create();
            Assert.That((Live.buffers, Live.renderTextures), Is.EqualTo((buffers + 1, textures + 1)));
            buffer.Dispose();
            buffer.Dispose();
            texture.Release();
            Assert.That((Live.buffers, Live.renderTextures), Is.EqualTo((buffers, textures)));
        }

        [Test]
        void A_test_can_have_memory_run_out()
        {
            Faults.allocationsLeft = 1;
            using (new GraphicsBuffer(GraphicsBuffer.Target.Raw, 4, 4)) Assert.Throws<UnityException>(() => new GraphicsBuffer(GraphicsBuffer.Target.Raw, 4, 4));
        }

        [Test]
        void Read_backs_last_one_frame()
        {
            using (var buffer = new GraphicsBuffer(GraphicsBuffer.Target.Raw, 1, 4))
            {
                buffer.SetData(new[] { 42u });
                var request = AsyncGPUReadback.Request(buffer);
                Assert.That(request.done, Is.False);
                Assert.Throws<InvalidOperationException>(() => request.GetData<uint>());
                request.WaitForCompletion();
                var data = request.GetData<uint>();
                Assert.That(data[0], Is.EqualTo(42));
                Engine.Frame();
                Assert.Throws<InvalidOperationException>(() => request.GetData<uint>());
                Assert.Throws<ObjectDisposedException>(() => data.ToArray());
            }
        }

        [Test]
        void A_test_can_have_read_backs_fail()
        {
            using (var buffer = new GraphicsBuffer(GraphicsBuffer.Target.Raw, 1, 4))
            {
                Faults.failReadBacks = true;
                var request = AsyncGPUReadback.Request(buffer);
                request.WaitForCompletion();
                Assert.That(request.done && request.hasError);
            }
        }
    }

    class DrawTests
    {
        const string Text = @"
Shader ""Hidden/StandIn/Test""
{
    Properties { _Strength (""Strength"", Float) = 2 }
    SubShader
    {
        Cull Off
        Pass
        {
            Name ""Blend""
            ZTest Always ZWrite Off
            Blend One OneMinusSrcAlpha
HLSLPROGRAM
#pragma target 4.5
#pragma vertex cover
#pragma fragment paint
ByteAddressBuffer colors;
float4 cover(uint i : SV_VertexID) : SV_Position { return float4(float2(i & 1, i >> 1) * 4 - 1, .5, 1); }
float4 paint(float4 at : SV_Position) : SV_Target { return asfloat(colors.Load4(0)); }
ENDHLSL
        }
        Pass
        {
            ZTest LEqual ZWrite On
            ColorMask 0
HLSLPROGRAM
#pragma vertex cover
#pragma fragment deepen
float4 cover(uint i : SV_VertexID) : SV_Position { return float4(float2(i & 1, i >> 1) * 4 - 1, .5, 1); }
float deepen(float4 at : SV_Position) : SV_Depth { return at.y < 1 ? .25 : .75; }
ENDHLSL
        }
        Pass
        {
            ZTest Always ZWrite Off
HLSLPROGRAM
#pragma vertex cover
#pragma fragment look
Texture2D<float> _CameraDepthTexture;
float4 cover(uint i : SV_VertexID) : SV_Position { return float4(float2(i & 1, i >> 1) * 4 - 1, .5, 1); }
float4 look(float4 at : SV_Position) : SV_Target { return _CameraDepthTexture.Load(int3(at.xy, 0)); }
ENDHLSL
        }
    }
}";
        Shader shader;
        Material material;
        GraphicsBuffer colors;
        CommandBuffer commands;
        RenderTexture target;

        [SetUp]
        void Begin()
        {
            var file = System.IO.Path.Combine(Application.temporaryCachePath, "test.shader");
            System.IO.File.WriteAllText(file, Text);
            shader = Shader.Load(file);
            material = new Material(shader);
            colors = new GraphicsBuffer(GraphicsBuffer.Target.Raw, 4, 4);
            colors.SetData(new[] { .5f, .25f, 0, .5f });
            commands = new CommandBuffer { name = "draw" };
            target = new RenderTexture(new RenderTextureDescriptor(2, 2, GraphicsFormat.R32G32B32A32_SFloat, GraphicsFormat.D32_SFloat)) { name = "target" };
            target.Create();
        }

        [TearDown]
        void End()
        {
            colors.Dispose();
            commands.Dispose();
            UnityEngine.Object.DestroyImmediate(target);
        }

        void Draw(int pass)
        {
            var block = new MaterialPropertyBlock();
            block.SetBuffer("colors", colors);
            commands.DrawProcedural(Matrix4x4.identity, material, pass, MeshTopology.Triangles, 3, 1, block);
            block.Clear();
        }

        [Test]
        void Blends_as_the_shader_says()
        {
            commands.SetRenderTarget(target);
            commands.ClearRenderTarget(true, true, Color.white);
            Draw(material.FindPass("BLEND"));
            Graphics.ExecuteCommandBuffer(commands);
            foreach (var pixel in Pictures.Read(target).pixels) Assert.That((Vector4)pixel, Is.EqualTo(new Vector4(1, .75f, .5f, 1)));
            Assert.That(material.GetFloat("_Strength"), Is.EqualTo(2));
        }

        [Test]
        void Depth_is_reversed()
        {
            commands.SetRenderTarget(target);
            commands.ClearRenderTarget(true, true, Color.white, .5f);
            Draw(1);
            Graphics.ExecuteCommandBuffer(commands);
            var depth = Pictures.ReadDepth(target);
            Assert.That((depth.At(0, 0).r, depth.At(0, 1).r), Is.EqualTo((.5f, .75f)), "the row above is further away than what was there");
            Assert.That((Vector4)Pictures.Read(target).At(0, 1), Is.EqualTo(Vector4.one), "no colour is written");
        }

        [Test]
        void A_draw_without_its_buffer_is_skipped()
        {
            commands.SetRenderTarget(target);
            commands.DrawProcedural(Matrix4x4.identity, material, 0, MeshTopology.Triangles, 3, 1, null);
            Log.Expect(LogType.Error, "Shader (Hidden/StandIn/Test), pass 0: Property (colors) is not set");
            Graphics.ExecuteCommandBuffer(commands);
        }

        [Test]
        void A_draw_needs_a_target()
        {
            Draw(0);
            Log.Expect(LogType.Error, "nothing is the render target");
            Graphics.ExecuteCommandBuffer(commands);
        }

        [Test]
        void A_target_destroyed_before_execution_is_seen()
        {
            commands.SetRenderTarget(target);
            Draw(0);
            UnityEngine.Object.DestroyImmediate(target);
            // As colour and as depth.
            for (int i = 0; i < 2; i++) Log.Expect(LogType.Error, "the texture 'target' was destroyed before the CommandBuffer was executed");
            Log.Expect(LogType.Error, "nothing is the render target");
            Graphics.ExecuteCommandBuffer(commands);
        }

        [TestCase(true)]
        [TestCase(false)]
        void A_camera_runs_its_command_buffers_over_what_stands_in_the_scene(bool hdr)
        {
            var camera = new GameObject("Camera").AddComponent<Camera>();
            Engine.SetScreen(32, 16);
            camera.allowHDR = hdr;
            camera.clearFlags = CameraClearFlags.SolidColor;
            camera.backgroundColor = Color.black;
            // The lower half of the view is red and two metres away.
            Props.Plane(new Vector3(0, -1, 0), Vector3.up, Color.red);
            commands.SetRenderTarget(BuiltinRenderTextureType.CameraTarget);
            Draw(0);
            camera.AddCommandBuffer(CameraEvent.BeforeForwardAlpha, commands);
            Engine.Frame();
            var picture = Pictures.Color(camera);
            Assert.That(picture.width, Is.EqualTo(32));
            Assert.That(picture.At(16, 1).r, Is.EqualTo(1).Within(.01), "red seen through half of a half");
            Assert.That(picture.At(16, 14).r, Is.EqualTo(.5).Within(.01));
            // z of the plane in the lowest row, by the projection.
            float slope = Mathf.Tan(30 * Mathf.Deg2Rad) * (1 - 1 / 16f), distance = 1 / slope, near = camera.nearClipPlane, far = camera.farClipPlane;
            Assert.That(Pictures.Depth(camera).At(16, 0).r, Is.EqualTo(near * (far - distance) / (distance * (far - near))).Within(1e-4));
            Assert.That(Pictures.Depth(camera).At(16, 15).r, Is.Zero);
        }

        [Test]
        void The_depth_texture_is_there_where_it_is_asked_for()
        {
            var camera = new GameObject("Camera").AddComponent<Camera>();
            Engine.SetScreen(8, 8);
            Props.Sphere(new Vector3(0, 0, 2), 1, Color.green);
            commands.SetRenderTarget(BuiltinRenderTextureType.CameraTarget);
            commands.DrawProcedural(Matrix4x4.identity, material, 2, MeshTopology.Triangles, 3);
            camera.AddCommandBuffer(CameraEvent.BeforeForwardAlpha, commands);
            Log.Expect(LogType.Error, "Property (_CameraDepthTexture) is not set");
            Engine.Frame();
            camera.depthTextureMode = DepthTextureMode.Depth;
            Engine.Frame();
            Assert.That(Pictures.Color(camera).At(4, 4).r, Is.EqualTo(Pictures.Depth(camera).At(4, 4).r).Within(1e-3));
            Assert.That(Pictures.Depth(camera).At(4, 4).r, Is.GreaterThan(.2f));
            Assert.That(Pictures.Depth(camera).At(0, 0).r, Is.Zero);
        }

        [Test]
        void Two_eyes_share_an_array()
        {
            Headset.isOn = true;
            var camera = new GameObject("Camera").AddComponent<Camera>();
            Props.Sphere(new Vector3(0, 0, 2), .2f, Color.white);
            commands.SetSinglePassStereo(SinglePassStereoMode.None);
            commands.SetRenderTarget(new RenderTargetIdentifier(BuiltinRenderTextureType.CameraTarget, 0, CubemapFace.Unknown, 1));
            Draw(0);
            camera.AddCommandBuffer(CameraEvent.AfterEverything, commands);
            Engine.Frame();
            Picture left = Pictures.Color(camera, Camera.StereoscopicEye.Left), right = Pictures.Color(camera, Camera.StereoscopicEye.Right);
            Assert.That(left.At(0, 0).r, Is.Zero);
            Assert.That(right.At(0, 0).r, Is.EqualTo(.5f));
            Headset.mode = UnityEngine.XR.XRSettings.StereoRenderingMode.MultiPass;
            commands.Clear();
            Engine.Frame();
            Assert.That(Pictures.Color(camera, Camera.StereoscopicEye.Right).At(0, 0).r, Is.Zero);
        }

        [Test]
        void Pictures_are_saved()
        {
            var picture = new Picture(2, 1);
            picture.pixels[1] = Color.red;
            var png = picture.ToPng();
            Assert.That(png[1], Is.EqualTo((byte)'P'));
            Assert.That(png.Length, Is.GreaterThan(60));
        }
    }
}
